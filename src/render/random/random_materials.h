// Random colours, textures and materials of the generated scenes.
#pragma once

#include "core/random.h"
#include "render/trace/scene.h"

namespace ld {

inline bool chance(RandomStream& random, double probability) {
  return random.uniform() < static_cast<float>(probability);
}
/// Uniform in the logarithm; both bounds above 0.
float log_uniform(RandomStream& random, float low, float high);
/// Uniform over all rotations.
Basis random_rotation(RandomStream& random);

/// Reflectances between 0.05 and 0.9, some grey, some saturated.
Vec3 random_colour(RandomStream& random);

/// Any pattern, at a scale that fits an object of this size (scene units): from a few cells to dozens.
Texture random_texture(RandomStream& random, float size);

/// For an object of this size: diffuse 45 %, rough conductor 20, mirror 8, smooth dielectric 12, rough
/// dielectric 15.
Material random_material(RandomStream& random, float size);

/// For floors and walls: textured, mostly diffuse, now and then a glossy metal.
Material random_wall_material(RandomStream& random, float size);

}  // namespace ld
