#include "render/random/random_materials.h"

#include "render/geometry/sampling.h"

namespace ld {
namespace {

/// Hue, saturation and value, each in [0, 1], to RGB.
Vec3 from_hsv(float hue, float saturation, float value) {
  const auto channel = [&](float shift) {
    const float h = std::fmod(hue + shift, 1.0F) * 6;
    return std::clamp(std::abs(h - 3) - 1, 0.0F, 1.0F);
  };
  const Vec3 pure = {channel(0), channel(2.0F / 3), channel(1.0F / 3)};
  return mix(grey(1), pure, saturation) * value;
}

Texture plain(Vec3 colour) {
  Texture texture;
  texture.colour_a = texture.colour_b = colour;
  return texture;
}

/// Reflectances at normal incidence: gold, copper, silver, aluminium, iron, or any tint.
Vec3 metal_colour(RandomStream& random) {
  constexpr Vec3 kMetals[] = {{1.00F, 0.77F, 0.34F},
                              {0.95F, 0.64F, 0.54F},
                              {0.95F, 0.93F, 0.88F},
                              {0.91F, 0.92F, 0.92F},
                              {0.56F, 0.57F, 0.58F}};
  if (chance(random, 0.6)) return kMetals[random.below(5)];
  const float hue = random.uniform(), saturation = random.uniform(0, 0.7F);
  return from_hsv(hue, saturation, random.uniform(0.5F, 0.95F));
}

Vec3 glass_colour(RandomStream& random) {
  if (chance(random, 0.6)) return grey(1);
  const float hue = random.uniform(), saturation = random.uniform(0.1F, 0.5F);
  return from_hsv(hue, saturation, 1);
}

}  // namespace

float log_uniform(RandomStream& random, float low, float high) {
  return low * std::pow(high / low, random.uniform());
}

Basis random_rotation(RandomStream& random) {
  const float u = random.uniform(), v = random.uniform(), turn = 2 * kPi * random.uniform();
  const Basis around = basis_around(sample_sphere(u, v));
  const Vec3 x = around.x * std::cos(turn) + around.y * std::sin(turn);
  return {x, cross(around.z, x), around.z};
}

Vec3 random_colour(RandomStream& random) {
  const float hue = random.uniform();
  const float saturation = chance(random, 0.3) ? random.uniform(0, 0.15F) : random.uniform(0.2F, 0.9F);
  return from_hsv(hue, saturation, random.uniform(0.25F, 0.9F));
}

Texture random_texture(RandomStream& random, float size) {
  Texture texture;
  constexpr Pattern kPatterns[] = {Pattern::plain, Pattern::checker, Pattern::stripes, Pattern::rings,
                                   Pattern::dots,  Pattern::noise,   Pattern::marble};
  texture.pattern = kPatterns[random.below(7)];
  texture.colour_a = random_colour(random);
  // Either another colour or another shade of the same.
  texture.colour_b =
      chance(random, 0.5) ? random_colour(random) : texture.colour_a * random.uniform(0.15F, 0.7F);
  texture.orientation = random_rotation(random);
  texture.frequency = log_uniform(random, 1, 16) / size;
  texture.seed = random.bits();
  return texture;
}

Material random_material(RandomStream& random, float size) {
  Material material;
  const float kind = random.uniform();
  material.ior = random.uniform(1.3F, 1.7F);
  if (kind < 0.5F) {
    material.kind = MaterialKind::diffuse;
    material.colour = random_texture(random, size);
    material.roughness = 1;
  } else if (kind < 0.7F) {
    material.kind = MaterialKind::rough_conductor;
    material.colour = chance(random, 0.5) ? plain(metal_colour(random)) : random_texture(random, size);
    material.roughness = random.uniform(0.2F, 0.75F);
  } else if (kind < 0.78F) {
    material.kind = MaterialKind::mirror;
    material.colour = plain(metal_colour(random) * 0.98F);
    material.roughness = 0;
  } else if (kind < 0.88F) {
    material.kind = MaterialKind::smooth_dielectric;
    material.colour = plain(glass_colour(random));
    material.roughness = 0;
  } else {
    material.kind = MaterialKind::rough_dielectric;
    material.colour = plain(glass_colour(random));
    material.roughness = random.uniform(0.2F, 0.65F);
  }
  return material;
}

Material random_wall_material(RandomStream& random, float size) {
  Material material;
  material.colour = random_texture(random, size);
  if (chance(random, 0.12)) {
    material.kind = MaterialKind::rough_conductor;
    material.roughness = random.uniform(0.3F, 0.7F);
  }
  return material;
}

}  // namespace ld
