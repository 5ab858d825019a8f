// The building blocks that the shapes are made of.
#include "render/geometry/mesh_tools.h"
#include "render/geometry/sampling.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

/// Catmull-Rom between b and c; works on anything with + and *.
template <class V>
V between(V a, V b, V c, V d, float t) {
  const float t2 = t * t, t3 = t2 * t;
  const float wa = 0.5F * (-t3 + 2 * t2 - t), wb = 0.5F * (3 * t3 - 5 * t2 + 2);
  const float wc = 0.5F * (-3 * t3 + 4 * t2 + t), wd = 0.5F * (t3 - t2);
  return a * wa + b * wb + c * wc + d * wd;
}

template <class V>
std::vector<V> catmull_rom(const std::vector<V>& points, int steps, bool closed) {
  const int count = static_cast<int>(points.size());
  const auto at = [&](int i) {
    return points[static_cast<size_t>(closed ? (i + count) % count : std::clamp(i, 0, count - 1))];
  };
  std::vector<V> curve;
  for (int i = 0; i < (closed ? count : count - 1); ++i)
    for (int k = 0; k < steps; ++k)
      curve.push_back(between(at(i - 1), at(i), at(i + 1), at(i + 2), share(k, steps)));
  if (!closed) curve.push_back(points.back());
  return curve;
}

/// Directions across a curve that turn with it as little as they can (rotation minimizing frames, by
/// projection).
struct Frames {
  std::vector<Vec3> tangents, normals;
};

Frames frames_along(const std::vector<Vec3>& curve, bool closed) {
  const size_t count = curve.size();
  Frames frames;
  for (size_t i = 0; i < count; ++i) {
    const size_t before = i > 0 ? i - 1 : closed ? count - 1 : 0;
    const size_t after = i + 1 < count ? i + 1 : closed ? 0 : count - 1;
    const Vec3 along = curve[after] - curve[before];
    const bool stands = length(along) < 1e-12F;
    frames.tangents.push_back(!stands ? normalize(along) : i > 0 ? frames.tangents.back() : Vec3{0, 1, 0});
    const Vec3 t = frames.tangents.back();
    if (i == 0) {
      frames.normals.push_back(basis_around(t).x);
      continue;
    }
    const Vec3 carried = frames.normals.back() - t * dot(t, frames.normals.back());
    frames.normals.push_back(length(carried) > 1e-6F ? normalize(carried) : basis_around(t).x);
  }
  if (!closed) return frames;
  // What is missing to the first normal after one round is spread over the curve.
  const Vec3 t = frames.tangents[0], first = frames.normals[0];
  Vec3 last = frames.normals.back() - t * dot(t, frames.normals.back());
  last = length(last) > 1e-6F ? normalize(last) : first;
  const float missing = std::atan2(dot(cross(last, first), t), dot(last, first));
  for (size_t i = 0; i < count; ++i) {
    const float angle = missing * static_cast<float>(i) / static_cast<float>(count);
    const Vec3 n = frames.normals[i], b = cross(frames.tangents[i], n);
    frames.normals[i] = n * std::cos(angle) + b * std::sin(angle);
  }
  return frames;
}

}  // namespace

Mesh make_surface(int columns, int rows, float crease, const std::function<Vec3(int i, int j)>& point) {
  Mesh mesh;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      mesh.positions.push_back(point(i, j));
      mesh.uvs.push_back({share(i, columns), share(j, rows)});
    }
  const auto index = [&](int i, int j) { return static_cast<uint32_t>(j * (columns + 1) + i); };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      mesh.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  shade(mesh, crease);
  return mesh;
}

Mesh make_lathe(const std::vector<Vec2>& profile, int around, float crease) {
  return make_surface(around, static_cast<int>(profile.size()) - 1, crease, [&](int i, int j) {
    const float angle = 2 * kPi * share(i % around, around);
    const Vec2 p = profile[static_cast<size_t>(j)];
    const float radius = std::max(0.0F, p.x);
    return Vec3{radius * std::cos(angle), p.y, -radius * std::sin(angle)};
  });
}

Mesh make_prism(const std::vector<Vec2>& outline, float half_height, float twist, float taper, int rows) {
  const int columns = static_cast<int>(outline.size());
  return make_surface(columns, rows + 2, kCrease, [&](int i, int j) {
    const float t = share(std::clamp(j - 1, 0, rows), rows);
    const float size = j == 0 || j == rows + 2 ? 0 : 1 + t * (taper - 1);
    const float c = std::cos(twist * t) * size, s = std::sin(twist * t) * size;
    const Vec2 p = outline[static_cast<size_t>(i % columns)];
    return Vec3{p.x * c - p.y * s, half_height * (2 * t - 1), -(p.x * s + p.y * c)};
  });
}

std::vector<Vec3> smooth_curve(const std::vector<Vec3>& points, int steps, bool closed) {
  return catmull_rom(points, steps, closed);
}

std::vector<Vec2> smooth_curve(const std::vector<Vec2>& points, int steps) {
  std::vector<Vec3> lifted;
  for (const Vec2 p : points) lifted.push_back({p.x, p.y, 0});
  std::vector<Vec2> curve;
  for (const Vec3 p : catmull_rom(lifted, steps, false)) curve.push_back({p.x, p.y});
  return curve;
}

Mesh make_tube(const std::vector<Vec3>& curve, const std::function<float(float)>& radius, int sides,
               bool closed) {
  const Frames frames = frames_along(curve, closed);
  const int count = static_cast<int>(curve.size());
  const int rows = closed ? count : count + 1;  // of an open one the first and last are the caps' middles
  return make_surface(sides, rows, kCrease, [&](int i, int j) {
    const int at = closed ? j % count : std::clamp(j - 1, 0, count - 1);
    const bool cap = !closed && (j == 0 || j == rows);
    const auto k = static_cast<size_t>(at);
    const float r = cap ? 0 : radius(share(at, closed ? count : std::max(1, count - 1)));
    const float angle = 2 * kPi * share(i % sides, sides);
    const Vec3 n = frames.normals[k], b = cross(frames.tangents[k], n);
    return curve[k] + n * (r * std::cos(angle)) + b * (r * std::sin(angle));
  });
}

Mesh make_tube(const std::vector<Vec3>& curve, float radius, int sides, bool closed) {
  return make_tube(
      curve, [=](float) { return radius; }, sides, closed);
}

Mesh make_block(Vec3 centre, Vec3 half) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0F, 1.0F}) {
      Vec3 n, u, v;
      n[axis] = side;
      u[(axis + 1) % 3] = side;
      v[(axis + 2) % 3] = 1;
      const auto first = static_cast<uint32_t>(mesh.positions.size());
      for (const Vec2 c : {Vec2{-1, -1}, Vec2{1, -1}, Vec2{1, 1}, Vec2{-1, 1}}) {
        mesh.positions.push_back(centre + (n + u * c.x + v * c.y) * half);
        mesh.normals.push_back(n);
        mesh.uvs.push_back({0.5F + 0.5F * c.x, 0.5F + 0.5F * c.y});
      }
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
    }
  return mesh;
}

Mesh make_rod(Vec3 from, Vec3 to, float radius, int sides) {
  return make_tube({from, to}, radius, sides, false);
}

}  // namespace ld
