#include "render/shading/patterns.h"

#include "core/random.h"
#include "render/geometry/noise.h"

namespace ld {
namespace {

float fraction(float x) {
  return x - static_cast<float>(floor_to_int(x));
}

float checker(Vec3 p) {
  return ((floor_to_int(p.x) + floor_to_int(p.y) + floor_to_int(p.z)) & 1) != 0 ? 1.0F : 0.0F;
}

float stripes(float x) {
  return fraction(x) < 0.5F ? 1.0F : 0.0F;
}

/// Balls on the lattice; each cell draws its own radius.
float dots(Vec3 p, uint32_t seed) {
  const int32_t x = floor_to_int(p.x), y = floor_to_int(p.y), z = floor_to_int(p.z);
  const Vec3 from_centre = {p.x - static_cast<float>(x) - 0.5F, p.y - static_cast<float>(y) - 0.5F,
                            p.z - static_cast<float>(z) - 0.5F};
  const float radius = 0.2F + 0.28F * to_unit(lattice_hash(x, y, z, seed));
  return dot(from_centre, from_centre) < radius * radius ? 1.0F : 0.0F;
}

float contrast(float noise) {
  return std::clamp(0.5F + 1.2F * noise, 0.0F, 1.0F);
}

/// Blocks of the given size in rows shifted by half a block, every one of another shade, with mortar between.
float bricks(Vec3 p, Vec3 size, float mortar, uint32_t seed) {
  const Vec3 q = p / size;
  const int32_t row = floor_to_int(q.y);
  const float shift = (row & 1) != 0 ? 0.5F : 0.0F;
  const float x = q.x + shift, z = q.z + shift;
  const Vec3 in_cell = {fraction(x) * size.x, fraction(q.y) * size.y, fraction(z) * size.z};
  // The pattern is solid; a wall cuts its third direction somewhere, so mortar there would swallow the wall.
  if (in_cell.x < mortar || in_cell.y < mortar) return 1;
  return 0.45F * to_unit(lattice_hash(floor_to_int(x), row, floor_to_int(z), seed));
}

float tiles(Vec3 p, uint32_t seed) {
  constexpr float kGrout = 0.06F;
  if (fraction(p.x) < kGrout || fraction(p.y) < kGrout || fraction(p.z) < 0.5F * kGrout) return 1;
  return 0.25F * to_unit(lattice_hash(floor_to_int(p.x), floor_to_int(p.y), floor_to_int(p.z), seed));
}

/// Growth rings around the y axis, bent by noise, with fine fibres along it.
float wood(Vec3 p, uint32_t seed) {
  const Vec3 bent = p + Vec3{1, 0, 1} * (0.7F * gradient_noise(p * Vec3{0.6F, 0.12F, 0.6F}, seed));
  const float ring = fraction(std::sqrt(bent.x * bent.x + bent.z * bent.z));
  const float fibres = gradient_noise(p * Vec3{14, 0.7F, 14}, seed + 1);
  return std::clamp(ring * ring * ring * 0.9F + 0.1F + 0.25F * fibres, 0.0F, 1.0F);
}

/// Threads along x and y that pass over and under each other.
float weave(Vec3 p) {
  const bool over = ((floor_to_int(p.x) + floor_to_int(p.y)) & 1) != 0;
  const float across = over ? fraction(p.x) : fraction(p.y), along = over ? fraction(p.y) : fraction(p.x);
  const float round = 4 * across * (1 - across), bulge = 4 * along * (1 - along);
  const float shade = std::sqrt(round) * (0.6F + 0.4F * bulge);
  return over ? 0.5F * shade : 1 - 0.5F * shade;
}

constexpr int kCellsAround = 27;

/// The two nearest of the points scattered one to a cell.
struct Nearest {
  float first = 0, second = 0;  // distances
  uint32_t cell = 0;            // hash of the nearest's
};

/// The points of the 27 cells around one: their hashes and squared distances from p. Side by side, as the
/// corners in noise.cpp are.
__attribute__((target_clones("avx2", "default"))) void points_around(Vec3 p, uint32_t seed, uint32_t* hashes,
                                                                     float* squares) {
  const int32_t x = floor_to_int(p.x) - 1, y = floor_to_int(p.y) - 1, z = floor_to_int(p.z) - 1;
  for (int32_t c = 0; c < kCellsAround; ++c) {
    const int32_t i = x + c % 3, j = y + c / 3 % 3, k = z + c / 9;
    const uint32_t h = lattice_hash(i, j, k, seed);
    const float dx = p.x - (static_cast<float>(i) + static_cast<float>(h & 1023) / 1024);
    const float dy = p.y - (static_cast<float>(j) + static_cast<float>(h >> 10 & 1023) / 1024);
    const float dz = p.z - (static_cast<float>(k) + static_cast<float>(h >> 20 & 1023) / 1024);
    hashes[c] = h;
    squares[c] = dx * dx + dy * dy + dz * dz;
  }
}

Nearest nearest_points(Vec3 p, uint32_t seed) {
  uint32_t hashes[kCellsAround];
  float squares[kCellsAround];
  points_around(p, seed, hashes, squares);
  float first = 1e18F, second = 1e18F;
  Nearest nearest;
  for (int c = 0; c < kCellsAround; ++c)
    if (squares[c] < first) {
      second = first;
      first = squares[c];
      nearest.cell = hashes[c];
    } else {
      second = std::min(second, squares[c]);
    }
  nearest.first = std::sqrt(first);
  nearest.second = std::sqrt(second);
  return nearest;
}

/// Something like print: in the xy plane, characters of 5x7 mirrored random dots, with spaces and line gaps.
float glyphs(Vec3 p, uint32_t seed) {
  constexpr int kColumns = 5, kRows = 7;
  constexpr float kLineHeight = 1.8F;
  const float line = p.y / kLineHeight;
  const int32_t row = floor_to_int(line), column = floor_to_int(p.x);
  const auto i = static_cast<int>(fraction(p.x) * (kColumns + 1));
  const auto j = static_cast<int>(fraction(line) * (kRows + 3));
  const uint32_t letter = lattice_hash(column, row, 0, seed);
  if (i >= kColumns || j >= kRows || letter % 6 == 0) return 0;
  const int mirrored = (letter & 64) != 0 ? std::min(i, kColumns - 1 - i) : i;
  // 26 letters, each a fixed pattern of dots.
  const uint32_t dots_of_letter = lattice_hash(mirrored, j, static_cast<int32_t>(letter / 6 % 26), seed + 1);
  return dots_of_letter % 100 < 48 ? 1.0F : 0.0F;
}

}  // namespace

float pattern_value(Pattern pattern, Vec3 p, uint32_t seed) {
  switch (pattern) {
    case Pattern::checker:
      return checker(p);
    case Pattern::stripes:
      return stripes(p.x);
    case Pattern::rings:
      return stripes(std::sqrt(p.x * p.x + p.y * p.y));
    case Pattern::dots:
      return dots(p, seed);
    case Pattern::noise:
      return contrast(fractal_noise(p, 3, seed));
    case Pattern::marble:
      return 0.5F + 0.5F * std::sin(2 * kPi * (p.x + 1.5F * fractal_noise(p * 0.5F, 2, seed)));
    case Pattern::bricks:
      return bricks(p, {1, 0.4F, 1}, 0.05F, seed);
    case Pattern::tiles:
      return tiles(p, seed);
    case Pattern::wood:
      return wood(p, seed);
    case Pattern::weave:
      return weave(p);
    case Pattern::gradient:
      return 0.5F - 0.5F * std::cos(kPi * p.x);
    case Pattern::voronoi:
      return to_unit(nearest_points(p, seed).cell * 2654435761U);
    case Pattern::cracks: {
      const Nearest nearest = nearest_points(p, seed);
      return nearest.second - nearest.first < 0.07F ? 1.0F : 0.0F;
    }
    case Pattern::glyphs:
      return glyphs(p, seed);
    default:
      return 0;
  }
}

}  // namespace ld
