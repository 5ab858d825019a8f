// Warps of uniform numbers to directions and points, with their densities, and the power heuristic.
#pragma once

#include <cstddef>

#include "render/geometry/vec3.h"

namespace ld {

/// Uniform on the unit disk, continuous (Shirley and Chiu 1997).
inline Vec2 sample_disk(float u, float v) {
  const float a = 2 * u - 1, b = 2 * v - 1;
  if (a == 0 && b == 0) return {0, 0};
  const bool wide = std::abs(a) > std::abs(b);
  const float radius = wide ? a : b;
  const float angle = wide ? kPi / 4 * (b / a) : kPi / 2 - kPi / 4 * (a / b);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

/// Density cos / pi over solid angle, around +z.
inline Vec3 sample_cosine_hemisphere(float u, float v) {
  const Vec2 d = sample_disk(u, v);
  return {d.x, d.y, std::sqrt(std::max(0.0F, 1 - d.x * d.x - d.y * d.y))};
}

/// Uniform in the cone around +z whose solid angle is 2 pi (1 - cos_radius).
inline Vec3 sample_cone(float cos_radius, float u, float v) {
  const float z = 1 - u * (1 - cos_radius);
  const float r = std::sqrt(std::max(0.0F, 1 - z * z));
  return {r * std::cos(2 * kPi * v), r * std::sin(2 * kPi * v), z};
}

/// Uniform on the unit sphere.
inline Vec3 sample_sphere(float u, float v) {
  return sample_cone(-1, u, v);
}

/// Share of bin i in a cumulative distribution that ends at 1.
inline float bin_share(const float* cumulative, size_t i) {
  return cumulative[i] - (i == 0 ? 0 : cumulative[i - 1]);
}

/// The bin that u in [0, 1) falls into, and u stretched to [0, 1) within it. Never an empty bin, unless all
/// are.
inline size_t choose_bin(const float* cumulative, size_t count, float& u) {
  auto i = static_cast<size_t>(std::upper_bound(cumulative, cumulative + count, u) - cumulative);
  if (i == count) --i;  // rounding left the last sum below 1
  while (i > 0 && bin_share(cumulative, i) <= 0) --i;
  u = std::clamp((u - (i == 0 ? 0 : cumulative[i - 1])) / bin_share(cumulative, i), 0.0F, 0x1.fffffep-1F);
  return i;
}

/// Weight of the strategy with density `own` beside one with density `other` (Veach 1997, beta = 2).
inline float power_heuristic(float own, float other) {
  if (own <= 0) return 0;
  const float ratio = other / own;  // the quotient first: the square of a large density would overflow
  return 1 / (1 + ratio * ratio);
}

}  // namespace ld
