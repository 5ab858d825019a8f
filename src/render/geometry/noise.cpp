#include "render/geometry/noise.h"

namespace ld {
namespace {

float fade(float t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}
float lerp(float a, float b, float t) {
  return a + (b - a) * t;
}

/// Dot product with one of the twelve edge directions of a cube.
inline float gradient(uint32_t hash, float x, float y, float z) {
  const uint32_t h = hash >> 28;
  const float u = h < 8 ? x : y;
  const float v = h < 4 ? y : (h == 12 || h == 14) ? x : z;
  return ((h & 1) != 0 ? -u : u) + ((h & 2) != 0 ? -v : v);
}

}  // namespace

// The eight corners are arrays, so that the compiler can take them side by side; with AVX2, where the machine
// has it, all at once. No instruction set that is named here fuses products with sums: the bits are the same
// everywhere.
__attribute__((target_clones("avx2", "default"))) float gradient_noise(Vec3 p, uint32_t seed) {
  constexpr int kCorners = 8;  // x changes fastest, z slowest
  const int32_t ix = floor_to_int(p.x), iy = floor_to_int(p.y), iz = floor_to_int(p.z);
  const Vec3 f = {p.x - static_cast<float>(ix), p.y - static_cast<float>(iy), p.z - static_cast<float>(iz)};
  float values[kCorners];
  for (int c = 0; c < kCorners; ++c) {
    const int dx = c & 1, dy = c >> 1 & 1, dz = c >> 2;
    values[c] = gradient(lattice_hash(ix + dx, iy + dy, iz + dz, seed), f.x - static_cast<float>(dx),
                         f.y - static_cast<float>(dy), f.z - static_cast<float>(dz));
  }
  const float u = fade(f.x), v = fade(f.y), w = fade(f.z);
  return lerp(lerp(lerp(values[0], values[1], u), lerp(values[2], values[3], u), v),
              lerp(lerp(values[4], values[5], u), lerp(values[6], values[7], u), v), w);
}

float fractal_noise(Vec3 p, int octaves, uint32_t seed) {
  float sum = 0, amplitude = 0.5F;
  for (int i = 0; i < octaves; ++i) {
    sum += amplitude * gradient_noise(p, seed + static_cast<uint32_t>(i));
    p *= 2.0F;
    amplitude *= 0.5F;
  }
  return sum * 1.5F;
}

}  // namespace ld
