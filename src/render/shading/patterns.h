// What the procedural textures draw.
#pragma once

#include <cstdint>

#include "render/shading/texture.h"

namespace ld {

/// The share of a texture's second colour, in [0, 1], at `p` in cells of the pattern. 0 for Pattern::plain
/// and for pictures.
float pattern_value(Pattern pattern, Vec3 p, uint32_t seed);

}  // namespace ld
