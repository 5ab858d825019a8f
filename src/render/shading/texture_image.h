// Pictures that textures and probes look up.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "render/geometry/vec3.h"

namespace ld {

struct TextureImage {
  int width = 0, height = 0;
  std::vector<Vec3> texels;  // linear RGB or plain numbers; row 0 on top

  /// Bilinear between the four texels around (x, y), where texel (i, j) has its centre at (i + 0.5, j + 0.5).
  /// Wraps in x; in y it wraps or, with `clamp_y`, repeats the border row.
  Vec3 bilinear(float x, float y, bool clamp_y) const;
};

enum class TextureUse {
  colour,  // R, G, B; sRGB where the file stores small integers (PNG, JPEG), linear otherwise
  data,    // the numbers as stored, in [0, 1] for integers (roughness, masks)
  alpha,   // the alpha channel in all three components; 1 where there is none
};

/// Any picture OpenImageIO reads. Throws Error: missing, not a picture, more than 16384 a side. Grey pictures
/// fill all three components; NaN, infinite and negative values become 0.
std::shared_ptr<const TextureImage> read_texture_image(const std::filesystem::path& path, TextureUse use);

/// The same from the bytes of a PNG, JPEG or other file that lies within another; `name` is what complaints
/// call it.
std::shared_ptr<const TextureImage> decode_texture_image(const std::vector<uint8_t>& bytes,
                                                         const std::string& name, TextureUse use);

}  // namespace ld
