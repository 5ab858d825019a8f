// Surfaces of functions in space.
#include <map>
#include <utility>

#include "render/geometry/mesh_tools.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

/// Marching tetrahedra: every cube of the lattice is cut in six tetrahedra along its main diagonal, which fit
/// together across cubes.
class LevelSet {
 public:
  LevelSet(const std::function<float(Vec3)>& inside, int cells) : cells_(cells), nodes_(cells + 1) {
    for (int z = 0; z < nodes_; ++z)
      for (int y = 0; y < nodes_; ++y)
        for (int x = 0; x < nodes_; ++x) {
          const Vec3 p = {2 * share(x, cells) - 1, 2 * share(y, cells) - 1, 2 * share(z, cells) - 1};
          points_.push_back(p);
          const bool edge = x == 0 || y == 0 || z == 0 || x == cells || y == cells || z == cells;
          const float value = inside(p);
          values_.push_back(edge ? std::min(value, -0.02F) : value);
        }
  }

  Mesh surface() {
    // The corners of the six tetrahedra: from one end of the diagonal along the three axes in each order.
    constexpr int kOrders[6][3] = {{1, 2, 4}, {2, 1, 4}, {1, 4, 2}, {4, 1, 2}, {2, 4, 1}, {4, 2, 1}};
    for (int z = 0; z < cells_; ++z)
      for (int y = 0; y < cells_; ++y)
        for (int x = 0; x < cells_; ++x)
          for (const auto& order : kOrders) {
            const int second = order[0], third = second | order[1];
            add_tetrahedron(
                {node(x, y, z, 0), node(x, y, z, second), node(x, y, z, third), node(x, y, z, 7)});
          }
    shade(mesh_, 1);
    return std::move(mesh_);
  }

 private:
  uint32_t node(int x, int y, int z, int corner) const {
    x += corner & 1;
    y += corner >> 1 & 1;
    z += corner >> 2 & 1;
    return static_cast<uint32_t>((z * nodes_ + y) * nodes_ + x);
  }

  /// The zero between two nodes of different sign.
  uint32_t crossing(uint32_t a, uint32_t b) {
    const auto key = std::minmax(a, b);
    const auto [entry, is_new] = crossings_.try_emplace(key, static_cast<uint32_t>(mesh_.positions.size()));
    if (is_new) {
      const float from = values_[key.first], to = values_[key.second];
      // A zero on a node itself would make triangles of no area.
      const float t = std::clamp(from / (from - to), 0.02F, 0.98F);
      mesh_.positions.push_back(mix(points_[key.first], points_[key.second], t));
    }
    return entry->second;
  }

  void add_triangle(uint32_t a, uint32_t b, uint32_t c, Vec3 outwards) {
    const auto& p = mesh_.positions;
    if (dot(cross(p[b] - p[a], p[c] - p[a]), outwards) < 0) std::swap(b, c);
    mesh_.triangles.push_back({a, b, c});
  }

  void add_tetrahedron(const std::array<uint32_t, 4>& corners) {
    std::vector<uint32_t> in, out;
    for (const uint32_t c : corners) (values_[c] > 0 ? in : out).push_back(c);
    if (in.empty() || out.empty()) return;
    Vec3 outwards;
    for (const uint32_t i : in)
      for (const uint32_t o : out) outwards += points_[o] - points_[i];
    if (in.size() == 2) {
      const uint32_t a = crossing(in[0], out[0]), b = crossing(in[0], out[1]);
      const uint32_t c = crossing(in[1], out[1]), d = crossing(in[1], out[0]);
      add_triangle(a, b, c, outwards);
      add_triangle(a, c, d, outwards);
      return;
    }
    const bool one_in = in.size() == 1;
    const uint32_t apex = one_in ? in[0] : out[0];
    const std::vector<uint32_t>& base = one_in ? out : in;
    const uint32_t a = crossing(apex, base[0]), b = crossing(apex, base[1]), c = crossing(apex, base[2]);
    add_triangle(a, b, c, outwards);
  }

  int cells_, nodes_;
  std::vector<Vec3> points_;
  std::vector<float> values_;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> crossings_;
  Mesh mesh_;
};

}  // namespace

Mesh make_level_set(const std::function<float(Vec3)>& inside, int cells) {
  return LevelSet(inside, cells).surface();
}

Mesh make_voxels(int x, int y, int z, const std::function<bool(int, int, int)>& filled) {
  const std::array<int, 3> size = {x, y, z};
  const auto is_filled = [&](const std::array<int, 3>& c) {
    for (size_t k = 0; k < 3; ++k)
      if (c[k] < 0 || c[k] >= size[k]) return false;
    return filled(c[0], c[1], c[2]);
  };
  Mesh mesh;
  for (int k = 0; k < z; ++k)
    for (int j = 0; j < y; ++j)
      for (int i = 0; i < x; ++i) {
        if (!filled(i, j, k)) continue;
        const Mesh cell = make_block(
            {static_cast<float>(i) + 0.5F, static_cast<float>(j) + 0.5F, static_cast<float>(k) + 0.5F},
            grey(0.5F));
        for (size_t face = 0; face < 6; ++face) {  // in make_block's order: -x, +x, -y, ...
          std::array<int, 3> beyond = {i, j, k};
          beyond[face / 2] += face % 2 == 0 ? -1 : 1;
          if (is_filled(beyond)) continue;
          const auto first = static_cast<uint32_t>(mesh.positions.size());
          for (size_t c = 4 * face; c < 4 * face + 4; ++c) {
            mesh.positions.push_back(cell.positions[c]);
            mesh.normals.push_back(cell.normals[c]);
            mesh.uvs.push_back(cell.uvs[c]);
          }
          mesh.triangles.push_back({first, first + 1, first + 2});
          mesh.triangles.push_back({first, first + 2, first + 3});
        }
      }
  return mesh;
}

}  // namespace ld
