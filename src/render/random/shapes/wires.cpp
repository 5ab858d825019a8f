// Thin things along curves: springs, knots, cables, chains, ropes.
#include "render/geometry/mesh_tools.h"
#include "render/geometry/sampling.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

Vec3 random_point(RandomStream& random) {
  const float u = random.uniform(), v = random.uniform(), r = std::cbrt(random.uniform());
  return sample_sphere(u, v) * r;
}

std::vector<Vec3> random_curve(RandomStream& random, int points, int steps) {
  std::vector<Vec3> corners;
  for (int i = 0; i < points; ++i) corners.push_back(random_point(random));
  return smooth_curve(corners, steps, false);
}

}  // namespace

Mesh make_helix(float turns, float radius, float height, float wire) {
  std::vector<Vec3> curve;
  const int steps = static_cast<int>(turns * 28);
  for (int i = 0; i <= steps; ++i) {
    const float t = share(i, steps), angle = 2 * kPi * turns * t;
    curve.push_back({radius * std::cos(angle), height * (t - 0.5F), radius * std::sin(angle)});
  }
  return make_tube(curve, wire, 10, false);
}

Mesh make_torus_knot(int p, int q, float tube) {
  std::vector<Vec3> curve;
  const int steps = 48 * std::max(p, q);
  for (int i = 0; i < steps; ++i) {
    const float t = 2 * kPi * share(i, steps);
    const float ring = 1 + 0.45F * std::cos(static_cast<float>(q) * t), turn = static_cast<float>(p) * t;
    curve.push_back(
        {ring * std::cos(turn), 0.45F * std::sin(static_cast<float>(q) * t), ring * std::sin(turn)});
  }
  return make_tube(curve, tube, 12, true);
}

Mesh make_cables(RandomStream& random, int count) {
  Mesh mesh;
  for (int i = 0; i < count; ++i) {
    const float radius = random.uniform(0.008F, 0.03F);
    append(mesh, make_tube(random_curve(random, 6, 14), radius, 6, false));
  }
  return mesh;
}

Mesh make_chain(RandomStream& random, int links) {
  const std::vector<Vec3> path = random_curve(random, 5, 40);
  // Links of equal length along the curve.
  std::vector<float> along = {0};
  for (size_t i = 1; i < path.size(); ++i) along.push_back(along.back() + length(path[i] - path[i - 1]));
  const auto at = [&](float s) {
    const auto after = std::upper_bound(along.begin() + 1, along.end() - 1, s);
    const auto i = static_cast<size_t>(after - along.begin());
    const float t = (s - along[i - 1]) / std::max(1e-6F, along[i] - along[i - 1]);
    return mix(path[i - 1], path[i], std::clamp(t, 0.0F, 1.0F));
  };
  const float pitch = along.back() / static_cast<float>(links), wire = 0.16F * pitch;
  Mesh mesh;
  Vec3 side = {1, 0, 0};
  for (int k = 0; k < links; ++k) {
    const float s = pitch * static_cast<float>(k);
    const Vec3 a = at(s), b = at(s + pitch), t = normalize(b - a + Vec3{0, 1e-7F, 0});
    side = side - t * dot(side, t);
    side = length(side) > 1e-3F ? normalize(side) : basis_around(t).x;
    const Vec3 across = k % 2 == 0 ? side : cross(t, side);
    std::vector<Vec3> ring;
    for (int i = 0; i < 20; ++i) {  // a stadium a little longer than the pitch, so that links hold each other
      const float angle = 2 * kPi * share(i, 20);
      const float x = std::cos(angle), y = std::sin(angle);
      ring.push_back(0.5F * (a + b) + t * (0.28F * pitch * x + std::copysign(0.34F * pitch, x)) +
                     across * (0.34F * pitch * y));
    }
    append(mesh, make_tube(ring, wire, 8, true));
  }
  return mesh;
}

Mesh make_rope(RandomStream& random) {
  const std::vector<Vec3> path = random_curve(random, 5, 36);
  const float radius = random.uniform(0.03F, 0.07F), twists = random.uniform(14, 26);
  Mesh mesh;
  for (int strand = 0; strand < 3; ++strand) {
    std::vector<Vec3> curve;
    for (size_t i = 0; i < path.size(); ++i) {
      const Vec3 t = path[std::min(i + 1, path.size() - 1)] - path[i > 0 ? i - 1 : 0];
      const Basis around = basis_around(normalize(t + Vec3{0, 1e-6F, 0}));
      const float angle =
          2 * kPi * (share(strand, 3) + twists * static_cast<float>(i) / static_cast<float>(path.size()));
      curve.push_back(path[i] + around.x * (radius * std::cos(angle)) +
                      around.y * (radius * std::sin(angle)));
    }
    append(mesh, make_tube(curve, 1.05F * radius, 8, false));
  }
  return mesh;
}

}  // namespace ld
