// Leaves, and the plants that are little more than leaves.
#include "render/geometry/mesh_tools.h"
#include "render/geometry/sampling.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

/// A leaf along `direction` from `root`, its upper side turned towards +y as far as that goes, rolled by
/// `roll`.
void add_leaf(Mesh& leaves, const Mesh& leaf, Vec3 root, Vec3 direction, float size, float roll) {
  const Vec3 y = normalize(direction);
  Vec3 z = -1.0F * (Vec3{0, 1, 0} - y * y.y);  // the leaf bends towards its z: downwards
  z = length(z) > 1e-3F ? normalize(z) : basis_around(y).x;
  const Basis flat = {cross(y, z), y, z};
  const float c = std::cos(roll), s = std::sin(roll);
  append(leaves, placed(leaf, grey(size), {flat.x * c + flat.z * s, y, flat.z * c - flat.x * s}, root));
}

Vec3 outwards(float azimuth, float elevation) {
  return {std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
          std::cos(elevation) * std::sin(azimuth)};
}

}  // namespace

Mesh make_leaf(float width, float bend, float fold, int rows) {
  return make_surface(2, rows, kPi, [&](int i, int j) {
    const float t = share(j, rows), side = static_cast<float>(i - 1);
    // Widest below the middle, pointed at both ends.
    const bool point = j == 0 || j == rows;
    const float half = point ? 0 : width * std::pow(std::sin(kPi * std::pow(t, 0.75F)), 0.9F);
    const float angle = bend * t;  // along a circle's arc
    const float y = std::abs(bend) > 1e-3F ? std::sin(angle) / bend : t;
    const float z = std::abs(bend) > 1e-3F ? (1 - std::cos(angle)) / bend : 0;
    return Vec3{side * half, y, z - fold * half * std::abs(side)};
  });
}

Plant make_grass(RandomStream& random) {
  Plant plant;
  const int blades = 120 + static_cast<int>(random.below(500));
  const float spread = random.uniform(0.15F, 0.8F), width = random.uniform(0.012F, 0.035F);
  for (int i = 0; i < blades; ++i) {
    const float u = random.uniform(), v = random.uniform();
    const Vec2 at = sample_disk(u, v);
    const float azimuth = random.uniform(0, 2 * kPi), height = random.uniform(0.5F, 1.2F);
    const float bend = random.uniform(0.2F, 1.6F), lean = random.uniform(0.75F, 1.5F);
    add_leaf(plant.leaves, make_leaf(width, bend, 0.3F, 6), {spread * at.x, 0, spread * at.y},
             outwards(azimuth, lean), height, 0);
  }
  return plant;
}

Plant make_potted_plant(RandomStream& random) {
  Plant plant;  // the stems and the pot's earth are one material
  const int count = 16 + static_cast<int>(random.below(60));
  const float width = random.uniform(0.06F, 0.22F), bend = random.uniform(0.5F, 1.8F),
              fold = random.uniform(0, 0.5F);
  const float stalk = random.uniform(0, 0.5F);
  const Mesh leaf = make_leaf(width, bend, fold, 10);
  for (int i = 0; i < count; ++i) {
    const float azimuth = 2.39996F * static_cast<float>(i) + random.uniform(-0.3F, 0.3F);  // the golden angle
    const float elevation = 0.25F + 1.2F * share(i, count) + random.uniform(-0.15F, 0.15F);
    const float size = random.uniform(0.5F, 0.95F), reach = stalk * random.uniform(0.5F, 1);
    const Vec3 direction = outwards(azimuth, std::min(elevation, 1.5F));
    const Vec3 root = direction * reach;
    if (reach > 0.05F) append(plant.stems, make_rod({0, -0.05F, 0}, root, 0.012F, 5));
    add_leaf(plant.leaves, leaf, root, direction, size, random.uniform(-0.3F, 0.3F));
  }
  return plant;
}

Plant make_fern(RandomStream& random) {
  Plant plant;
  const int fronds = 6 + static_cast<int>(random.below(9)), pairs = 14 + static_cast<int>(random.below(10));
  const float droop = random.uniform(0.8F, 1.6F), width = random.uniform(0.1F, 0.2F);
  const Mesh leaflet = make_leaf(width, 0.6F, 0.2F, 4);
  for (int f = 0; f < fronds; ++f) {
    const float azimuth = 2 * kPi * share(f, fronds) + random.uniform(-0.3F, 0.3F);
    const float rise = random.uniform(0.7F, 1.3F), size = random.uniform(0.7F, 1.1F);
    const Vec3 side = {-std::sin(azimuth), 0, std::cos(azimuth)};
    std::vector<Vec3> rib = {{}};
    for (int k = 1; k <= pairs; ++k)
      rib.push_back(rib.back() +
                    outwards(azimuth, rise - droop * share(k, pairs)) * (size / static_cast<float>(pairs)));
    append(plant.stems, make_tube(
                            rib, [](float t) { return 0.012F * (1 - 0.8F * t); }, 5, false));
    for (int k = 2; k < pairs; ++k) {
      const auto i = static_cast<size_t>(k);
      const Vec3 along = normalize(rib[i + 1] - rib[i]);
      const float length_here = 0.4F * size * std::sin(kPi * (0.12F + 0.86F * share(k, pairs)));
      for (const float s : {-1.0F, 1.0F})
        add_leaf(plant.leaves, leaflet, rib[i], along * 0.5F + side * s, length_here, 0);
    }
  }
  return plant;
}

Plant make_bush(RandomStream& random) {
  Plant plant;
  const int count = 500 + static_cast<int>(random.below(1100));
  const float size = random.uniform(0.09F, 0.2F), loose = random.uniform(0.1F, 0.5F);
  const float width = random.uniform(0.2F, 0.4F), bend = random.uniform(0.2F, 1);
  const Mesh leaf = make_leaf(width, bend, 0.25F, 4);
  const float height = random.uniform(0.7F, 1.3F);
  for (int i = 0; i < count; ++i) {
    const float u = random.uniform(), v = random.uniform(), w = random.uniform();
    const Vec3 out = sample_sphere(u, v);
    const Vec3 at = out * (1 - loose * w) * Vec3{1, height, 1};
    const float a = random.uniform(), b = random.uniform(), roll = random.uniform(-1, 1);
    add_leaf(plant.leaves, leaf, at, out + sample_sphere(a, b) * 0.9F, size * random.uniform(0.6F, 1.2F),
             roll);
  }
  for (int i = 0; i < 14; ++i) {
    const float u = random.uniform(), v = random.uniform();
    append(plant.stems,
           make_rod({0, -height, 0}, sample_sphere(u, v) * 0.85F * Vec3{1, height, 1}, 0.015F, 5));
  }
  return plant;
}

Plant make_flower(RandomStream& random) {
  Plant plant;  // petals are the leaves, the stem and the heart the stems
  const int blossoms = 1 + static_cast<int>(random.below(7)), petals = 5 + static_cast<int>(random.below(12));
  const float width = random.uniform(0.15F, 0.4F), open = random.uniform(0.05F, 0.9F);
  const float bend = random.uniform(-0.8F, 0.8F), fold = random.uniform(-0.3F, 0.3F);
  const Mesh petal = make_leaf(width, bend, fold, 8);
  for (int b = 0; b < blossoms; ++b) {
    const float azimuth = random.uniform(0, 2 * kPi), lean = random.uniform(0.9F, 1.5F);
    const float height = random.uniform(1.0F, 1.8F), size = random.uniform(0.25F, 0.5F);
    const Vec3 head = outwards(azimuth, lean) * height;
    append(plant.stems,
           make_tube(smooth_curve(std::vector<Vec3>{{}, {0.2F * head.x, 0.6F * head.y, 0.2F * head.z}, head},
                                  8, false),
                     0.018F, 6, false));
    const Basis around = basis_around(normalize(head - Vec3{0, 0.6F * head.y, 0}));
    append(plant.stems, placed(make_sphere(1), {0.2F * size, 0.2F * size, 0.12F * size}, around, head));
    for (int k = 0; k < petals; ++k) {
      const float angle = 2 * kPi * share(k, petals);
      const Vec3 out = around.x * std::cos(angle) + around.y * std::sin(angle);
      add_leaf(plant.leaves, petal, head + out * (0.12F * size), out + around.z * open, size, 0);
    }
  }
  return plant;
}

}  // namespace ld
