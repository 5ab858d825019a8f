// Gradient noise in space (Perlin, "Improving noise", SIGGRAPH 2002) and its fractal sum.
#pragma once

#include <cstdint>

#include "render/geometry/vec3.h"

namespace ld {

/// Smooth, about in [-1, 1], zero on the integer lattice; features are one unit apart. `seed` chooses the
/// pattern.
float gradient_noise(Vec3 p, uint32_t seed);

/// Sum of `octaves` noises of doubling frequency and halving amplitude, about in [-1, 1].
float fractal_noise(Vec3 p, int octaves, uint32_t seed);

/// The whole number at or below x, |x| < 2^31: without SSE 4.1 std::floor is a call into the C library.
inline int32_t floor_to_int(float x) {
  const auto truncated = static_cast<int32_t>(x);
  return truncated - (x < static_cast<float>(truncated) ? 1 : 0);
}

/// A hash of lattice coordinates, uniform over 32 bits.
inline uint32_t lattice_hash(int32_t x, int32_t y, int32_t z, uint32_t seed) {
  uint32_t h = seed ^ (static_cast<uint32_t>(x) * 0x8DA6B343U) ^ (static_cast<uint32_t>(y) * 0xD8163841U) ^
               (static_cast<uint32_t>(z) * 0xCB1AB31FU);
  // The finaliser of MurmurHash3.
  h = (h ^ (h >> 16)) * 0x85EBCA6BU;
  h = (h ^ (h >> 13)) * 0xC2B2AE35U;
  return h ^ (h >> 16);
}

}  // namespace ld
