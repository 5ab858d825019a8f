// Where a picture lies, so that pictures of one frame are compared pixel by pixel and not corner by corner.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "frame/exr_reader.h"
#include "frame/frame.h"

namespace ld {

/// Size and windows of pixels.
struct Extent {
  int width = 0, height = 0;
  Windows windows;
  bool operator==(const Extent& other) const {
    return width == other.width && height == other.height && windows == other.windows;
  }
  size_t pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
  std::string text() const;  // "4 x 3 pixels at (0, 0)"
};

Extent extent_of(const ExrReader& exr, int part);

/// Copies the pixels, of so many bytes each in rows, that lie in both extents; others of the target stay.
void place_pixels(const char* source, const Extent& from, char* target, const Extent& to, size_t pixel_bytes);

struct PicturePlace {
  Extent extent;
  /// Of red, green, blue and white, x and y; Rec. 709 where a file does not say.
  std::array<float, 8> chromaticities = {0.64F, 0.33F, 0.3F, 0.6F, 0.15F, 0.06F, 0.3127F, 0.329F};
};

PicturePlace place_of(const ExrReader& exr, int part);

/// Of a frame's samples, or of a file's picture where there are none. Throws Error as ExrReader does.
PicturePlace read_place(const std::filesystem::path& path);

/// The pixels of a picture that show the frame: all of them where both have one data window, a part where the
/// picture is a larger one of the same display window. Throws Error, which names both files and places, where
/// the picture does not show the whole frame.
Image cut_to(const Image& picture, const Extent& own, const std::string& path, const Extent& frame,
             const std::string& frame_path);

/// A reference as losses and metrics need it.
struct Reference {
  Image image;  // [3, H, W] linear, cut to its frame
  ReferenceFloor floor;
  int64_t bad_values = 0;      // NaN, infinite or negative ones, set to 0
  bool other_colours = false;  // its chromaticities are not the frame's
};

/// Of the frame that lies at `frame`. Throws Error as read_image and cut_to do.
Reference read_reference(const std::filesystem::path& path, const PicturePlace& frame,
                         const std::string& frame_path);

/// Whether the primaries and white agree within what rounding makes.
bool same_colours(const PicturePlace& a, const PicturePlace& b);

}  // namespace ld
