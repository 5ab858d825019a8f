#include "render/texture.h"

#include "render/noise.h"

namespace ld {
namespace {

int32_t floor_to_int(float x) {
  return static_cast<int32_t>(std::floor(x));
}

float checker(Vec3 p) {
  return ((floor_to_int(p.x) + floor_to_int(p.y) + floor_to_int(p.z)) & 1) != 0 ? 1.0F : 0.0F;
}

float stripes(float x) {
  return x - static_cast<float>(floor_to_int(x)) < 0.5F ? 1.0F : 0.0F;
}

/// Balls on the lattice; each cell draws its own radius.
float dots(Vec3 p, uint32_t seed) {
  const int32_t x = floor_to_int(p.x), y = floor_to_int(p.y), z = floor_to_int(p.z);
  const Vec3 from_centre = {p.x - static_cast<float>(x) - 0.5F, p.y - static_cast<float>(y) - 0.5F,
                            p.z - static_cast<float>(z) - 0.5F};
  const float radius = 0.2F + 0.28F * static_cast<float>(lattice_hash(x, y, z, seed) >> 8) * 0x1p-24F;
  return dot(from_centre, from_centre) < radius * radius ? 1.0F : 0.0F;
}

float contrast(float noise) {
  return std::clamp(0.5F + 1.2F * noise, 0.0F, 1.0F);
}

}  // namespace

Vec3 Texture::evaluate(Vec3 point) const {
  if (pattern == Pattern::plain) return colour_a;
  // The offset keeps lattice planes off the faces of axis-aligned walls, where rounding would speckle them.
  const Vec3 p = orientation.to_local(point) * frequency + Vec3{0.37F, 0.41F, 0.43F};
  switch (pattern) {
    case Pattern::plain:
      break;
    case Pattern::checker:
      return mix(colour_a, colour_b, checker(p));
    case Pattern::stripes:
      return mix(colour_a, colour_b, stripes(p.x));
    case Pattern::rings:
      return mix(colour_a, colour_b, stripes(std::sqrt(p.x * p.x + p.y * p.y)));
    case Pattern::dots:
      return mix(colour_a, colour_b, dots(p, seed));
    case Pattern::noise:
      return mix(colour_a, colour_b, contrast(fractal_noise(p, 3, seed)));
    case Pattern::marble:
      return mix(colour_a, colour_b,
                 0.5F + 0.5F * std::sin(2 * kPi * (p.x + 1.5F * fractal_noise(p * 0.5F, 2, seed))));
  }
  return colour_a;
}

}  // namespace ld
