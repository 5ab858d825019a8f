#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "core/error.h"
#include "frame/exr_reader.h"
#include "frame/frame_file.h"

namespace ld {

namespace {

/// What programs call the part of the picture, in small letters; "" where there is one part.
bool is_picture_name(std::string name) {
  static const std::set<std::string> names = {"",    "mean",  "denoised", "c",        "beauty", "rgba",
                                              "rgb", "color", "colour",   "image",    "main",   "combined",
                                              "ci",  "final", "default",  "rgb_color"};
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char letter) { return std::tolower(letter); });
  // Blender's parts are called VIEWLAYER.Combined.
  return names.count(name) > 0 || names.count(name.substr(name.rfind('.') + 1)) > 0;
}

}  // namespace

int picture_part(const ExrReader& exr) {
  std::vector<int> coloured, named;
  std::string list;
  for (int part = 0; part < exr.parts(); ++part) {
    const std::string name = exr.part_name(part);
    list += (list.empty() ? "'" : ", '") + name + "'";
    if (sample_number(name) >= 0 || !exr.has_channel(part, "R") || !exr.has_channel(part, "G") ||
        !exr.has_channel(part, "B"))
      continue;
    coloured.push_back(part);
    if (is_picture_name(name)) named.push_back(part);
  }
  if (coloured.size() == 1) return coloured[0];
  if (named.size() == 1) return named[0];
  if (coloured.empty())
    fail("{}: no part has the channels R, G and B; found {}{}; write the picture with these names",
         exr.path(), exr.channel_list(0), exr.parts() > 1 ? " in the first of the parts " + list : "");
  fail("{}: several parts may be the picture ({}); call that part 'beauty', or write it alone", exr.path(),
       list);
}

Image read_rgb(const ExrReader& exr) {
  const int part = picture_part(exr);
  Image image(exr.width(part), exr.height(part), 3);
  std::vector<ExrPlane> planes;
  for (int c = 0; c < 3; ++c) {
    const std::string channel(1, "RGB"[c]);
    exr.require_channel(part, channel, "");
    planes.push_back({channel, image.plane(c), image.plane_size()});
  }
  exr.read(part, planes);
  return image;
}

int64_t mend_image(Image& image) {
  int64_t bad = 0;
  for (float& value : image.pixels) {
    if (std::isfinite(value) && value >= 0) continue;
    value = 0;
    ++bad;
  }
  return bad;
}

Image read_image(const std::filesystem::path& path, int64_t* bad_values) {
  Image image = read_rgb(ExrReader(path));
  const int64_t bad = mend_image(image);
  if (bad_values != nullptr) *bad_values = bad;
  return image;
}

}  // namespace ld
