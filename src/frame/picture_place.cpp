#include "frame/picture_place.h"

#include <ImfStandardAttributes.h>

#include <cmath>

#include "core/error.h"
#include "frame/frame_attributes.h"
#include "frame/frame_file.h"

namespace ld {
namespace {

Windows with_display(const PicturePlace& place) {
  Windows windows = place.windows;
  if (windows.has_display()) return windows;
  windows.display_left = windows.x;
  windows.display_top = windows.y;
  windows.display_right = windows.x + place.width - 1;
  windows.display_bottom = windows.y + place.height - 1;
  return windows;
}

bool same_display(const PicturePlace& a, const PicturePlace& b) {
  Windows first = with_display(a), second = with_display(b);
  first.x = second.x;
  first.y = second.y;
  return first == second;
}

std::string text_of(const PicturePlace& place) {
  return fmt::format("{}x{} pixels at ({}, {})", place.width, place.height, place.windows.x, place.windows.y);
}

}  // namespace

PicturePlace place_of(const ExrReader& exr, int part) {
  PicturePlace place;
  place.width = exr.width(part);
  place.height = exr.height(part);
  place.windows = windows_of(exr.header(part));
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

Image cut_to(const Image& picture, const PicturePlace& own, const std::string& path,
             const PicturePlace& frame, const std::string& frame_path) {
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
        path, text_of(own), frame_path, text_of(frame),
        same_display(own, frame) ? "" : ", of another display window");
  Image part(frame.width, frame.height, picture.channels);
  for (int c = 0; c < picture.channels; ++c)
    for (int y = 0; y < frame.height; ++y)
      std::copy_n(picture.plane(c) + (down + y) * own.width + right, frame.width,
                  part.plane(c) + int64_t{y} * frame.width);
  return part;
}

bool same_colours(const PicturePlace& a, const PicturePlace& b) {
  for (size_t i = 0; i < a.chromaticities.size(); ++i)
    if (!(std::fabs(a.chromaticities[i] - b.chromaticities[i]) < 2e-3F)) return false;
  return true;
}

}  // namespace ld
