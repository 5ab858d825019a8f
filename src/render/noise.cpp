#include "render/noise.h"

namespace ld {
namespace {

float fade(float t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}
float lerp(float a, float b, float t) {
  return a + (b - a) * t;
}

/// Dot product with one of the twelve edge directions of a cube.
float gradient(uint32_t hash, float x, float y, float z) {
  const uint32_t h = hash >> 28;
  const float u = h < 8 ? x : y;
  const float v = h < 4 ? y : (h == 12 || h == 14) ? x : z;
  return ((h & 1) != 0 ? -u : u) + ((h & 2) != 0 ? -v : v);
}

}  // namespace

uint32_t lattice_hash(int32_t x, int32_t y, int32_t z, uint32_t seed) {
  uint32_t h = seed ^ (static_cast<uint32_t>(x) * 0x8DA6B343U) ^ (static_cast<uint32_t>(y) * 0xD8163841U) ^
               (static_cast<uint32_t>(z) * 0xCB1AB31FU);
  // The finaliser of MurmurHash3.
  h = (h ^ (h >> 16)) * 0x85EBCA6BU;
  h = (h ^ (h >> 13)) * 0xC2B2AE35U;
  return h ^ (h >> 16);
}

float gradient_noise(Vec3 p, uint32_t seed) {
  const int32_t ix = floor_to_int(p.x), iy = floor_to_int(p.y), iz = floor_to_int(p.z);
  const Vec3 f = {p.x - static_cast<float>(ix), p.y - static_cast<float>(iy), p.z - static_cast<float>(iz)};
  const float u = fade(f.x), v = fade(f.y), w = fade(f.z);
  float planes[2];
  for (int k = 0; k < 2; ++k) {
    float rows[2];
    for (int j = 0; j < 2; ++j) {
      const float y = f.y - static_cast<float>(j), z = f.z - static_cast<float>(k);
      rows[j] = lerp(gradient(lattice_hash(ix, iy + j, iz + k, seed), f.x, y, z),
                     gradient(lattice_hash(ix + 1, iy + j, iz + k, seed), f.x - 1, y, z), u);
    }
    planes[k] = lerp(rows[0], rows[1], v);
  }
  return lerp(planes[0], planes[1], w);
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
