#include "render/geometry/mesh.h"

#include <map>
#include <utility>

#include "render/geometry/noise.h"

namespace ld {
namespace {

/// Normals as the area-weighted mean of the triangles around each position.
void smooth_normals(Mesh& mesh) {
  mesh.normals.assign(mesh.positions.size(), Vec3{});
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 n = cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
    for (const uint32_t i : {a, b, c}) mesh.normals[i] += n;
  }
  for (Vec3& n : mesh.normals) n = normalize(n);
}

void add_quad(Mesh& mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

/// Splits each triangle in four, the new corners pushed out to the unit sphere.
void quarter(Mesh& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
  const auto middle = [&](uint32_t a, uint32_t b) {
    const auto [entry, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(mesh.positions.size()));
    if (is_new) mesh.positions.push_back(normalize(mesh.positions[a] + mesh.positions[b]));
    return entry->second;
  };
  std::vector<std::array<uint32_t, 3>> quarters;
  for (const auto& [a, b, c] : mesh.triangles) {
    const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    quarters.insert(quarters.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  mesh.triangles = std::move(quarters);
}

}  // namespace

Mesh make_sphere(int levels) {
  Mesh mesh;
  const float g = 0.5F * (1 + std::sqrt(5.0F));  // the golden ratio: corners of an icosahedron
  for (const Vec3 p :
       {Vec3{-1, g, 0}, Vec3{1, g, 0}, Vec3{-1, -g, 0}, Vec3{1, -g, 0}, Vec3{0, -1, g}, Vec3{0, 1, g},
        Vec3{0, -1, -g}, Vec3{0, 1, -g}, Vec3{g, 0, -1}, Vec3{g, 0, 1}, Vec3{-g, 0, -1}, Vec3{-g, 0, 1}})
    mesh.positions.push_back(normalize(p));
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int i = 0; i < levels; ++i) quarter(mesh);
  mesh.normals = mesh.positions;
  return mesh;
}

Mesh make_box() {
  Mesh mesh;
  for (uint32_t i = 0; i < 8; ++i)
    mesh.positions.push_back(
        {(i & 1) != 0 ? 1.0F : -1.0F, (i & 2) != 0 ? 1.0F : -1.0F, (i & 4) != 0 ? 1.0F : -1.0F});
  add_quad(mesh, 0, 4, 6, 2);  // -x
  add_quad(mesh, 1, 3, 7, 5);  // +x
  add_quad(mesh, 0, 1, 5, 4);  // -y
  add_quad(mesh, 2, 6, 7, 3);  // +y
  add_quad(mesh, 0, 2, 3, 1);  // -z
  add_quad(mesh, 4, 5, 7, 6);  // +z
  return mesh;
}

Mesh make_torus(float tube, int around, int across) {
  Mesh mesh;
  for (int i = 0; i < around; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / static_cast<float>(around);
    const Vec3 outward = {std::cos(a), 0, std::sin(a)};
    for (int j = 0; j < across; ++j) {
      const float b = 2 * kPi * static_cast<float>(j) / static_cast<float>(across);
      const Vec3 n = outward * std::cos(b) + Vec3{0, std::sin(b), 0};
      mesh.positions.push_back(outward + n * tube);
      mesh.normals.push_back(n);
    }
  }
  const auto index = [&](int i, int j) { return static_cast<uint32_t>(i % around * across + j % across); };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j)
      add_quad(mesh, index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j));
  return mesh;
}

Mesh make_blob(float amplitude, float frequency, int octaves, uint32_t seed, int levels) {
  Mesh mesh = make_sphere(levels);
  for (Vec3& p : mesh.positions)
    p *= 1 + amplitude * fractal_noise(p * frequency + grey(7.3F), octaves, seed);
  smooth_normals(mesh);
  return mesh;
}

Mesh make_ground(float size, int cells, float amplitude, float frequency, uint32_t seed) {
  Mesh mesh;
  for (int k = 0; k <= cells; ++k)
    for (int i = 0; i <= cells; ++i) {
      Vec3 p = {size * (2 * static_cast<float>(i) / static_cast<float>(cells) - 1), 0,
                size * (2 * static_cast<float>(k) / static_cast<float>(cells) - 1)};
      if (amplitude != 0) p.y = amplitude * fractal_noise(p * frequency + grey(0.5F), 4, seed);
      mesh.positions.push_back(p);
    }
  const auto index = [&](int i, int k) { return static_cast<uint32_t>(k * (cells + 1) + i); };
  for (int k = 0; k < cells; ++k)
    for (int i = 0; i < cells; ++i)
      add_quad(mesh, index(i, k), index(i, k + 1), index(i + 1, k + 1), index(i + 1, k));
  if (amplitude != 0) smooth_normals(mesh);
  return mesh;
}

Mesh make_parallelogram(Vec3 corner, Vec3 edge_u, Vec3 edge_v) {
  Mesh mesh;
  mesh.positions = {corner, corner + edge_u, corner + edge_u + edge_v, corner + edge_v};
  add_quad(mesh, 0, 1, 2, 3);
  return mesh;
}

void place(Mesh& mesh, Vec3 scale, const Basis& orientation, Vec3 translation) {
  for (Vec3& p : mesh.positions) p = orientation.to_world(p * scale) + translation;
  for (Vec3& n : mesh.normals) n = orientation.to_world(normalize(n / scale));
}

void turn_inside_out(Mesh& mesh) {
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  for (Vec3& n : mesh.normals) n = -n;
}

}  // namespace ld
