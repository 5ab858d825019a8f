#include <cmath>

#include "frame/exr_reader.h"
#include "frame/frame_attributes.h"
#include "frame/frame_file.h"

namespace ld {

Image read_rgb(const ExrReader& exr) {
  Image image(exr.width(0), exr.height(0), 3);
  std::vector<ExrPlane> planes;
  for (int c = 0; c < 3; ++c) {
    const std::string channel(1, "RGB"[c]);
    exr.require_channel(0, channel, "expected R, G and B in the first part; write the picture there");
    planes.push_back({channel, image.plane(c), image.plane_size()});
  }
  exr.read(0, planes);
  return image;
}

Image read_image(const std::filesystem::path& path, int64_t* bad_pixels, ReferenceFloor* floor) {
  const ExrReader exr(path);
  Image image = read_rgb(exr);
  if (floor != nullptr) *floor = read_floor(exr.header(0), exr.path());
  int64_t bad = 0;
  for (float& value : image.pixels) {
    if (std::isfinite(value) && value >= 0) continue;
    value = 0;
    ++bad;
  }
  if (bad_pixels != nullptr) *bad_pixels = bad;
  return image;
}

}  // namespace ld
