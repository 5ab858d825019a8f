#include "import/former_result.h"

#include "core/error.h"
#include "import/recognise.h"

namespace ld {

const char* const kDenoisedAlready =
    "denoised already, as its attribute ldDenoisedBy says; expected samples as they were rendered";

std::string denoised_attribute(const std::string& prefix) {
  return prefix + "ldDenoisedBy";
}

bool is_denoised(const ExrReader& exr, const FileViews& views, int part) {
  return exr.header(part).find(denoised_attribute(views.prefix())) != exr.header(part).end();
}

bool is_former_result(const std::string& path, const std::string& view) {
  try {
    const ExrReader exr(path);
    if (is_frame(exr)) return false;
    const FileViews views(exr, view);
    for (int part = 0; part < exr.parts(); ++part)
      if (views.name_of(part, views.prefix() + "R")) return is_denoised(exr, views, part);
  } catch (const Error&) {
    return false;
  }
  return false;
}

}  // namespace ld
