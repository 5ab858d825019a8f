#include "frame/picture_place.h"

#include <ImfStandardAttributes.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "frame/frame_attributes.h"
#include "frame/frame_file.h"

namespace ld {
namespace {

Windows with_display(const Extent& extent) {
  Windows windows = extent.windows;
  if (windows.has_display()) return windows;
  windows.display_left = windows.x;
  windows.display_top = windows.y;
  windows.display_right = windows.x + extent.width - 1;
  windows.display_bottom = windows.y + extent.height - 1;
  return windows;
}

bool same_display(const Extent& a, const Extent& b) {
  Windows first = with_display(a), second = with_display(b);
  first.x = second.x;
  first.y = second.y;
  return first == second;
}

}  // namespace

std::string Extent::text() const {
  return fmt::format("{} x {} pixels at ({}, {})", width, height, windows.x, windows.y);
}

Extent extent_of(const ExrReader& exr, int part) {
  return {exr.width(part), exr.height(part), windows_of(exr.header(part))};
}

void place_pixels(const char* source, const Extent& from, char* target, const Extent& to,
                  size_t pixel_bytes) {
  const auto bytes = static_cast<int64_t>(pixel_bytes);
  // Windows may lie anywhere: their distance need not fit an int.
  const int64_t right = int64_t{from.windows.x} - to.windows.x, down = int64_t{from.windows.y} - to.windows.y;
  const int64_t first = std::max<int64_t>(0, right), last = std::min<int64_t>(to.width, right + from.width);
  const int64_t bottom = std::min<int64_t>(to.height, down + from.height);
  for (int64_t y = std::max<int64_t>(0, down); y < bottom && first < last; ++y)
    std::copy_n(source + ((y - down) * from.width + (first - right)) * bytes, (last - first) * bytes,
                target + (y * to.width + first) * bytes);
}

PicturePlace place_of(const ExrReader& exr, int part) {
  PicturePlace place;
  place.extent = extent_of(exr, part);
  if (Imf::hasChromaticities(exr.header(part))) {
    const Imf::Chromaticities& c = Imf::chromaticities(exr.header(part));
    place.chromaticities = {c.red.x, c.red.y, c.green.x, c.green.y, c.blue.x, c.blue.y, c.white.x, c.white.y};
  }
  return place;
}

PicturePlace read_place(const std::filesystem::path& path) {
  const ExrReader exr(path);
  for (int part = 0; part < exr.parts(); ++part)
    if (sample_number(exr.part_name(part)) >= 0) return place_of(exr, part);
  return place_of(exr, picture_part(exr));
}

Image cut_to(const Image& picture, const Extent& own, const std::string& path, const Extent& frame,
             const std::string& frame_path) {
  // Windows may lie anywhere: their distance need not fit an int.
  const int64_t right = int64_t{frame.windows.x} - own.windows.x,
                down = int64_t{frame.windows.y} - own.windows.y;
  const bool whole = right == 0 && down == 0 && own.width == frame.width && own.height == frame.height;
  if (whole) return picture;
  const bool inside =
      right >= 0 && down >= 0 && right + frame.width <= own.width && down + frame.height <= own.height;
  if (!inside || !same_display(own, frame))
    fail(
        "{} is {}, its frame {} {}{}; both must show the same picture: write it with the frame's data "
        "window, or render one of them "
        "again",
        path, own.text(), frame_path, frame.text(),
        same_display(own, frame) ? "" : ", of another display window");
  Image part(frame.width, frame.height, picture.channels);
  for (int c = 0; c < picture.channels; ++c)
    place_pixels(reinterpret_cast<const char*>(picture.plane(c)), own, reinterpret_cast<char*>(part.plane(c)),
                 frame, sizeof(float));
  return part;
}

Reference read_reference(const std::filesystem::path& path, const PicturePlace& frame,
                         const std::string& frame_path) {
  const ExrReader exr(path);
  const int part = picture_part(exr);
  const PicturePlace own = place_of(exr, part);
  Reference reference;
  Image whole = read_rgb(exr);
  reference.bad_values = mend_image(whole);
  reference.floor = read_floor(exr.header(part), exr.path());
  reference.image = cut_to(whole, own.extent, path.string(), frame.extent, frame_path);
  reference.other_colours = !same_colours(own, frame);
  return reference;
}

bool same_colours(const PicturePlace& a, const PicturePlace& b) {
  for (size_t i = 0; i < a.chromaticities.size(); ++i)
    if (!(std::fabs(a.chromaticities[i] - b.chromaticities[i]) < 2e-3F)) return false;
  return true;
}

}  // namespace ld
