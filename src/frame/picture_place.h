// Where a picture lies, so that pictures of one frame are compared pixel by pixel and not corner by corner.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "frame/exr_reader.h"
#include "frame/frame.h"

namespace ld {

struct PicturePlace {
  int width = 0, height = 0;
  Windows windows;
  /// Of red, green, blue and white, x and y; Rec. 709 where a file does not say.
  std::array<float, 8> chromaticities = {0.64F, 0.33F, 0.3F, 0.6F, 0.15F, 0.06F, 0.3127F, 0.329F};
};

PicturePlace place_of(const ExrReader& exr, int part);

/// Of a frame's samples, or of a file's picture where there are none. Throws Error as ExrReader does.
PicturePlace read_place(const std::filesystem::path& path);

/// The pixels of a picture that show the frame: all of them where both have one data window, a part where the
/// picture is a larger one of the same display window. Throws Error, which names both files and places, where
/// the picture does not show the whole frame.
Image cut_to(const Image& picture, const PicturePlace& own, const std::string& path,
             const PicturePlace& frame, const std::string& frame_path);

/// Whether the primaries and white agree within what rounding makes.
bool same_colours(const PicturePlace& a, const PicturePlace& b);

}  // namespace ld
