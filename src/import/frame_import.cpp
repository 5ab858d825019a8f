#include "import/frame_import.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "frame/exr_check.h"
#include "frame/exr_reader.h"
#include "import/frame_builder.h"

namespace ld {

ImportedFrame import_frame(const std::vector<std::filesystem::path>& files, const ImportMapping& mapping,
                           const std::optional<ViewCamera>& camera, bool allow_identical,
                           const std::vector<std::string>& also) {
  if (files.empty()) fail_usage("no files with samples; name them behind the options");
  FrameBuilder builder(mapping, camera, allow_identical, also);
  for (const std::filesystem::path& file : files) builder.survey(file);
  for (const std::filesystem::path& file : files) builder.read(file);
  return builder.finish();
}

void require_valid_sample(const Frame& frame, const std::string& file) {
  if (std::all_of(frame.valid.begin(), frame.valid.end(), [](uint8_t valid) { return valid == 0; }))
    fail(
        "{}: nothing to see: every sample of every pixel is NaN or infinite, in radiance or alpha, or was "
        "not drawn; render it again",
        file);
}

ImportedPicture import_picture(const std::filesystem::path& file, const ImportMapping& mapping) {
  const ExrReader exr(file);
  ImportMapping own = mapping;
  if (FileViews(exr, "").all().empty()) own.view.clear();  // whose view it is goes without saying
  const std::vector<SourceSample> samples = plan_samples(exr, own, Wanted::picture);
  if (samples.size() != 1)
    fail("{}: holds {} samples; expected one converged picture", exr.path(), samples.size());
  const SourceSample& picture = samples[0];
  FrameWindow window;
  window.add(exr, picture);
  const Extent extent = window.extent();
  Converter converter(extent.width, extent.height, extent.windows, std::nullopt);
  ImportedPicture result;
  result.windows = extent.windows;
  const bool alpha = picture.alpha.mapping != nullptr;
  result.image = Image(extent.width, extent.height, alpha ? 4 : 3);
  int channel = 0;
  for (const SourceFeature* source : {&picture.features[0], &picture.alpha}) {
    if (source->mapping == nullptr) continue;
    for (const std::vector<float>& plane : read_feature(exr, *source, extent, converter))
      std::copy(plane.begin(), plane.end(), result.image.plane(channel++));
  }
  const auto end = result.image.pixels.begin() + static_cast<std::ptrdiff_t>(3 * result.image.plane_size());
  if (std::none_of(result.image.pixels.begin(), end, [](float value) { return std::isfinite(value); }))
    fail("{}: every pixel is NaN or infinite; render it again", exr.path());
  return result;
}

}  // namespace ld
