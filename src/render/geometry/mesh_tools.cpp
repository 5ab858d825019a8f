#include "render/geometry/mesh_tools.h"

#include <cstring>
#include <unordered_map>
#include <utility>

namespace ld {
namespace {

struct PlaceHash {
  size_t operator()(const std::array<uint32_t, 3>& bits) const {
    uint64_t h = 0x9E3779B97F4A7C15ULL;
    for (const uint32_t b : bits) h = (h ^ b) * 0xD6E8FEB86659FD93ULL, h ^= h >> 32;
    return static_cast<size_t>(h);
  }
};

/// The same number for positions in the same place.
std::vector<uint32_t> weld(const std::vector<Vec3>& positions) {
  std::unordered_map<std::array<uint32_t, 3>, uint32_t, PlaceHash> places;
  std::vector<uint32_t> place(positions.size());
  for (size_t i = 0; i < positions.size(); ++i) {
    std::array<uint32_t, 3> bits{};
    const Vec3 p = positions[i] + grey(0);  // -0 becomes +0
    std::memcpy(bits.data(), &p, sizeof bits);
    place[i] = places.try_emplace(bits, static_cast<uint32_t>(places.size())).first->second;
  }
  return place;
}

/// The triangles around each place, one list after the other.
struct Neighbours {
  std::vector<uint32_t> begin, triangles;
};

Neighbours neighbours_of(const Mesh& mesh, const std::vector<uint32_t>& place) {
  Neighbours around;
  around.begin.assign(place.size() + 2, 0);  // there are at most as many places as positions
  for (const auto& triangle : mesh.triangles)
    for (const uint32_t i : triangle) ++around.begin[place[i] + 2];
  for (size_t i = 2; i < around.begin.size(); ++i) around.begin[i] += around.begin[i - 1];
  around.triangles.resize(3 * mesh.triangles.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const uint32_t i : mesh.triangles[t])
      around.triangles[around.begin[place[i] + 1]++] = static_cast<uint32_t>(t);
  return around;
}

Vec3 unit_or_up(Vec3 v) {
  const float size = length(v);
  return size > 0 ? v / size : Vec3{0, 1, 0};
}

bool equal(Vec3 a, Vec3 b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

}  // namespace

void shade(Mesh& mesh, float crease) {
  const std::vector<uint32_t> place = weld(mesh.positions);
  auto& all = mesh.triangles;
  const auto collapsed = [&](const std::array<uint32_t, 3>& t) {
    return place[t[0]] == place[t[1]] || place[t[1]] == place[t[2]] || place[t[2]] == place[t[0]];
  };
  all.erase(std::remove_if(all.begin(), all.end(), collapsed), all.end());

  std::vector<Vec3> areas, units;  // of the triangles: twice the area along the normal, and the normal
  for (const auto& [a, b, c] : all) {
    areas.push_back(cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]));
    units.push_back(unit_or_up(areas.back()));
  }
  const Neighbours around = neighbours_of(mesh, place);
  const float least = std::cos(std::min(crease, kPi)) - 1e-4F;

  Mesh shaded;
  std::vector<std::vector<uint32_t>> copies(mesh.positions.size());  // of each position, one a normal
  for (size_t t = 0; t < all.size(); ++t) {
    std::array<uint32_t, 3> corners{};
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t i = all[t][k];
      Vec3 sum;
      for (uint32_t n = around.begin[place[i]]; n < around.begin[place[i] + 1]; ++n) {
        const uint32_t other = around.triangles[n];
        if (dot(units[t], units[other]) >= least) sum += areas[other];
      }
      const Vec3 normal = unit_or_up(is_black(sum) ? units[t] : sum);
      const auto copy = std::find_if(copies[i].begin(), copies[i].end(),
                                     [&](uint32_t c) { return equal(shaded.normals[c], normal); });
      if (copy != copies[i].end()) {
        corners[k] = *copy;
        continue;
      }
      corners[k] = static_cast<uint32_t>(shaded.positions.size());
      copies[i].push_back(corners[k]);
      shaded.positions.push_back(mesh.positions[i]);
      shaded.normals.push_back(normal);
      if (!mesh.uvs.empty()) shaded.uvs.push_back(mesh.uvs[i]);
    }
    shaded.triangles.push_back(corners);
  }
  mesh = std::move(shaded);
}

void append(Mesh& mesh, Mesh other) {
  if (mesh.positions.empty()) {
    mesh = std::move(other);
    return;
  }
  if (mesh.normals.empty() != other.normals.empty()) shade(mesh.normals.empty() ? mesh : other, 0);
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  const bool has_uvs = !mesh.uvs.empty() && !other.uvs.empty();
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  mesh.normals.insert(mesh.normals.end(), other.normals.begin(), other.normals.end());
  if (has_uvs)
    mesh.uvs.insert(mesh.uvs.end(), other.uvs.begin(), other.uvs.end());
  else
    mesh.uvs.clear();
  for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({a + first, b + first, c + first});
}

Bounds bounds_of(const std::vector<Vec3>& positions) {
  Bounds bounds = {positions.at(0), positions.at(0)};
  for (const Vec3 p : positions)
    for (int i = 0; i < 3; ++i) {
      bounds.low[i] = std::min(bounds.low[i], p[i]);
      bounds.high[i] = std::max(bounds.high[i], p[i]);
    }
  return bounds;
}

float radius_around(const std::vector<Vec3>& positions, Vec3 centre) {
  float radius = 0;
  for (const Vec3 p : positions) radius = std::max(radius, length(p - centre));
  return radius;
}

Basis turned_about(Vec3 axis, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  const auto turn = [&](Vec3 v) { return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1 - c)); };
  return {turn({1, 0, 0}), turn({0, 1, 0}), turn({0, 0, 1})};
}

Mesh placed(Mesh mesh, Vec3 scale, const Basis& orientation, Vec3 translation) {
  place(mesh, scale, orientation, translation);
  return mesh;
}

Mesh moved(Mesh mesh, Vec3 translation) {
  for (Vec3& p : mesh.positions) p += translation;
  return mesh;
}

}  // namespace ld
