// Closed solids with a formula.
#include <array>

#include "render/geometry/mesh_tools.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

/// sign(x) |x|^e; the float cosine of a right angle counts as the 0 it stands for.
float signed_power(float x, float e) {
  return std::abs(x) < 1e-6F ? 0.0F : std::copysign(std::pow(std::abs(x), e), x);
}

float superformula(const SuperFormula& f, float angle) {
  const float c = std::pow(std::abs(std::cos(0.25F * f.m * angle)), f.n2);
  const float s = std::pow(std::abs(std::sin(0.25F * f.m * angle)), f.n3);
  return std::clamp(std::pow(c + s + 1e-6F, -1 / f.n1), 0.15F, 4.0F);
}

Mesh dodecahedron() {
  // The corners are the centres of an icosahedron's faces; each of its corners becomes a pentagon.
  const Mesh dual = make_sphere(0);
  Mesh mesh;
  for (uint32_t corner = 0; corner < dual.positions.size(); ++corner) {
    const Vec3 n = dual.positions[corner];
    const Basis around = basis_around(n);
    std::vector<std::pair<float, Vec3>> ring;
    for (const auto& [a, b, c] : dual.triangles)
      if (a == corner || b == corner || c == corner) {
        const Vec3 p = normalize(dual.positions[a] + dual.positions[b] + dual.positions[c]);
        ring.emplace_back(std::atan2(dot(p, around.y), dot(p, around.x)), p);
      }
    std::sort(ring.begin(), ring.end(), [](const auto& l, const auto& r) { return l.first < r.first; });
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (const auto& [angle, p] : ring) mesh.positions.push_back(p);
    for (uint32_t k = 1; k + 1 < ring.size(); ++k)
      mesh.triangles.push_back({first, first + k, first + k + 1});
  }
  shade(mesh, 0.1F);
  return mesh;
}

}  // namespace

Mesh make_cylinder(float half_height, float top, int around) {
  const float bevel = 0.04F * std::min(1.0F, half_height), h = half_height;
  std::vector<Vec2> profile = {{0, -h}, {1 - bevel, -h}, {1, -h + bevel}};
  if (top > 2 * bevel) {
    profile.push_back({top, h - bevel});
    profile.push_back({top - bevel, h});
  }
  profile.push_back({0, h});
  return make_lathe(profile, around);
}

Mesh make_capsule(float half_length, float radius, int around) {
  std::vector<Vec2> profile;
  constexpr int kSteps = 8;
  for (const float side : {-1.0F, 1.0F})
    for (int i = 0; i <= kSteps; ++i) {
      const float angle = 0.5F * kPi * share(side < 0 ? i : kSteps - i, kSteps);
      const bool pole = side < 0 ? i == 0 : i == kSteps;
      profile.push_back(
          {pole ? 0 : radius * std::sin(angle), side * (half_length + radius * std::cos(angle))});
    }
  return make_lathe(profile, around);
}

Mesh make_rounded_box(Vec3 half, float radius) {
  constexpr int kSteps = 4;  // of the quarter circle at an edge, on each of its two sides
  const Vec3 inner = {half.x - radius, half.y - radius, half.z - radius};
  // Where the lines run along axis i: the rounded parts finely, the flat one in one step.
  const auto line = [&](int axis, int i) {
    const float side = i <= kSteps ? -1.0F : 1.0F;
    const int from_flat = i <= kSteps ? kSteps - i : i - kSteps - 1;
    if (from_flat == kSteps) return side * half[axis];  // exactly, so that the six sides meet
    return side * (inner[axis] + radius * std::tan(0.25F * kPi * share(from_flat, kSteps)));
  };
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool front : {false, true}) {
      const int last = 2 * kSteps + 1, a = (axis + 1) % 3, b = (axis + 2) % 3;
      append(mesh, make_surface(last, last, kPi, [&](int i, int j) {
               Vec3 p;
               p[axis] = front ? half[axis] : -half[axis];
               p[a] = line(a, front ? i : last - i);
               p[b] = line(b, j);
               // Towards the round: the point's box coordinates become a direction from the inner box.
               Vec3 core;
               for (int k = 0; k < 3; ++k) core[k] = std::clamp(p[k], -inner[k], inner[k]);
               return core + normalize(p - core) * radius;
             }));
    }
  shade(mesh, kCrease);
  return mesh;
}

std::vector<Vec2> star_outline(int points, float inner) {
  std::vector<Vec2> outline;
  for (int i = 0; i < 2 * points; ++i) {
    const float angle = kPi * share(i, points), radius = i % 2 == 0 ? 1.0F : inner;
    outline.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return outline;
}

std::vector<Vec2> gear_outline(int teeth, float depth) {
  std::vector<Vec2> outline;
  // Each tooth: up the flank, along the tip, down the flank, along the root.
  constexpr std::array<std::array<float, 2>, 4> kTooth = {{{0, 0}, {0.15F, 1}, {0.45F, 1}, {0.6F, 0}}};
  for (int i = 0; i < teeth; ++i)
    for (const auto& [where, height] : kTooth) {
      const float angle = 2 * kPi * (static_cast<float>(i) + where) / static_cast<float>(teeth);
      const float radius = 1 - depth * (1 - height);
      outline.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
  return outline;
}

Mesh make_platonic(int faces) {
  Mesh mesh;
  switch (faces) {
    case 4:
      mesh.positions = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
      mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
      break;
    case 6:
      return make_block({}, grey(1));
    case 8:
      mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
      mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                        {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
      break;
    case 12:
      return dodecahedron();
    default:
      mesh = make_sphere(0);
      break;
  }
  shade(mesh, 0.1F);
  return mesh;
}

Mesh make_superellipsoid(float north, float east, int cells) {
  const int rows = cells / 2;
  return make_surface(cells, rows, kCrease, [&](int i, int j) {
    const float u = 2 * kPi * share(i % cells, cells), v = kPi * (share(j, rows) - 0.5F);
    const float ring = j == 0 || j == rows ? 0.0F : signed_power(std::cos(v), north);
    return Vec3{ring * signed_power(std::cos(u), east), signed_power(std::sin(v), north),
                -ring * signed_power(std::sin(u), east)};
  });
}

Mesh make_supertoroid(float tube, float north, float east, int cells) {
  const int rows = cells / 2;
  return make_surface(cells, rows, kCrease, [&](int i, int j) {
    const float u = 2 * kPi * share(i % cells, cells), v = 2 * kPi * share(j % rows, rows);
    const float ring = 1 + tube * signed_power(std::cos(v), north);
    return Vec3{ring * signed_power(std::cos(u), east), tube * signed_power(std::sin(v), north),
                -ring * signed_power(std::sin(u), east)};
  });
}

Mesh make_supershape(const SuperFormula& around, const SuperFormula& upwards, int cells) {
  const int rows = cells / 2;
  return make_surface(cells, rows, kCrease, [&](int i, int j) {
    const float u = 2 * kPi * share(i % cells, cells), v = kPi * (share(j, rows) - 0.5F);
    const float r1 = superformula(around, u), r2 = superformula(upwards, v);
    const float ring = j == 0 || j == rows ? 0.0F : r2 * std::cos(v);
    return Vec3{r1 * ring * std::cos(u), r2 * std::sin(v), -r1 * ring * std::sin(u)};
  });
}

Mesh make_seashell(float turns, float growth, float ridges) {
  std::vector<Vec3> spiral;
  constexpr int kSteps = 160;
  for (int i = 0; i <= kSteps; ++i) {
    const float t = share(i, kSteps), angle = 2 * kPi * turns * t, size = std::pow(t, growth);
    spiral.push_back({0.62F * size * std::cos(angle), 1.5F * (1 - size), 0.62F * size * std::sin(angle)});
  }
  const auto radius = [=](float t) {
    return std::pow(t, growth) * 0.42F * (1 + 0.06F * std::sin(2 * kPi * ridges * t)) + 0.003F;
  };
  return make_tube(spiral, radius, 20, false);
}

}  // namespace ld
