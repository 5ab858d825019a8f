// Procedural solid textures: a colour for every point in space, so that no mesh needs texture coordinates.
#pragma once

#include <cstdint>

#include "render/vec3.h"

namespace ld {

enum class Pattern { plain, checker, stripes, rings, dots, noise, marble };

struct Texture {
  Pattern pattern = Pattern::plain;
  Vec3 colour_a = {0.5F, 0.5F, 0.5F};
  Vec3 colour_b = {0.5F, 0.5F, 0.5F};
  Basis orientation;    // of the pattern's axes
  float frequency = 1;  // cells per scene unit
  uint32_t seed = 0;

  /// Between the two colours; `p` is the point where the object stood at shutter open, in scene units.
  Vec3 evaluate(Vec3 p) const;
};

}  // namespace ld
