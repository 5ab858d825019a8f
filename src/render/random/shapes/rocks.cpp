// Rocks, crystals and pieces of land.
#include "render/geometry/mesh_tools.h"
#include "render/geometry/noise.h"
#include "render/geometry/sampling.h"
#include "render/random/shapes/shapes.h"

namespace ld {

Mesh make_rock(RandomStream& random) {
  struct Plane {
    Vec3 normal;
    float distance;
  };
  std::vector<Plane> planes;  // a ball with flat pieces cut off, roughened by noise
  const int count = 6 + static_cast<int>(random.below(16));
  for (int i = 0; i < count; ++i) {
    const float u = random.uniform(), v = random.uniform();
    planes.push_back({sample_sphere(u, v), random.uniform(0.55F, 0.95F)});
  }
  const float rough = random.uniform(0.02F, 0.15F), frequency = random.uniform(1.5F, 5);
  const uint32_t seed = random.bits();
  const Vec3 squash = {1, random.uniform(0.5F, 1), random.uniform(0.6F, 1)};
  Mesh mesh = make_sphere(4);
  mesh.normals.clear();
  for (Vec3& p : mesh.positions) {
    float distance = 1;
    for (const Plane& plane : planes) {
      const float facing = dot(p, plane.normal);
      if (facing > 0) distance = std::min(distance, plane.distance / facing);
    }
    const float bumps = fractal_noise(p * frequency + grey(3.1F), 4, seed);
    p = p * (distance * (1 + rough * bumps)) * squash;
  }
  shade(mesh, 0.5F);
  return mesh;
}

Mesh make_crystals(RandomStream& random) {
  Mesh mesh;
  const int count = 4 + static_cast<int>(random.below(12)), sides = 4 + static_cast<int>(random.below(4));
  for (int i = 0; i < count; ++i) {
    const float u = random.uniform(), v = random.uniform();
    const Vec3 lean = normalize(sample_cosine_hemisphere(u, v) + Vec3{0, 0, 0.35F});
    const float r = random.uniform(0.08F, 0.25F), h = random.uniform(0.4F, 1.2F),
                tip = r * random.uniform(0.6F, 1.6F);
    const float cut = random.uniform(0, 0.4F), turn = random.uniform(0, kPi);
    const Mesh column =
        make_lathe({{0, -0.2F}, {0.8F * r, -0.2F}, {r, h}, {cut * r, h + tip}, {0, h + tip}}, sides, 0.2F);
    const Basis around = basis_around({lean.x, lean.z, lean.y});
    const Basis spin = turned_about({0, 1, 0}, turn);
    append(mesh, placed(placed(column, grey(1), spin, {}), grey(1), {around.y, around.z, around.x}, {}));
  }
  return mesh;
}

Mesh make_terrain_block(RandomStream& random) {
  constexpr int kCells = 56;
  const float height = random.uniform(0.2F, 0.7F), frequency = random.uniform(0.8F, 2.2F), base = 0.5F;
  const bool ridged = random.below(2) == 0, terraced = random.below(4) == 0;
  const uint32_t seed = random.bits();
  const auto land = [=](float x, float z) {
    float h = fractal_noise(Vec3{x, 0.37F, z} * frequency, 5, seed);
    if (ridged) h = 1 - 2 * std::abs(h);
    if (terraced) h = std::floor(6 * h) / 6;
    return height * std::clamp(h, -0.6F, 1.2F);
  };
  const auto cell = [=](int i) { return 2 * share(std::clamp(i - 1, 0, kCells), kCells) - 1; };
  // The first and last lines are the top's border once more, down at the base.
  Mesh mesh = make_surface(kCells + 2, kCells + 2, 0.8F, [&](int i, int j) {
    const float x = cell(i), z = -cell(j);
    const bool skirt = i == 0 || j == 0 || i == kCells + 2 || j == kCells + 2;
    return Vec3{x, skirt ? -base : land(x, z), z};
  });
  append(mesh, make_surface(kCells, kCells, 0.8F, [&](int i, int j) {
           return Vec3{cell(i + 1), -base, -cell(kCells + 1 - j)};
         }));
  return mesh;
}

}  // namespace ld
