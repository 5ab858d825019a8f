// Pictures of all formats, for textures, and text as pixels: what OpenImageIO does. It is in a module
// (core/module.h), picture_formats_module.cpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/module.h"

namespace ld {

/// [height, width, channels], row 0 on top; integers are mapped to [0, 1].
struct DecodedPicture {
  int width = 0, height = 0, channels = 0;
  int alpha = -1;               // the channel that holds it; -1: none
  bool small_integers = false;  // the file stores integers of 8 or 16 bits: colours are sRGB
  std::vector<float> pixels;
};

class PictureFormats {
 public:
  virtual ~PictureFormats() = default;

  /// Any picture that OpenImageIO reads. Throws Error: missing, not a picture, more than `most` pixels a
  /// side.
  virtual DecodedPicture read(const std::filesystem::path& path, int most) const = 0;

  /// The same from the bytes of a PNG or JPEG file; `name` is what complaints call it.
  virtual DecodedPicture decode(const std::vector<uint8_t>& bytes, const std::string& name,
                                int most) const = 0;

  /// [height, width]: one line of text of that size in pixels, whose letters are 1 on 0, its baseline
  /// `baseline` rows below the top; text that is too long is cut. Empty when this machine has no font.
  virtual std::vector<float> draw_text(const std::string& text, int width, int height, int size, int left,
                                       int baseline) const = 0;
};

/// Loads the module at the first call. Throws Error when it is missing.
inline const PictureFormats& picture_formats() {
  static const auto* const formats = static_cast<const PictureFormats*>(
      load_module("ld_picture_formats", "reads textures and draws text",
                  "install the program again, or build all of it (cmake --build --preset release)"));
  return *formats;
}

}  // namespace ld
