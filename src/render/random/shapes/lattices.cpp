// Regular arrangements of thin bars: grilles, fences, blinds, lattices.
#include <set>
#include <utility>

#include "render/geometry/mesh_tools.h"
#include "render/random/shapes/shapes.h"

namespace ld {

Mesh make_wire_sphere(int levels, float wire) {
  const Mesh sphere = make_sphere(levels);
  std::set<std::pair<uint32_t, uint32_t>> edges;
  for (const auto& t : sphere.triangles)
    for (size_t i = 0; i < 3; ++i) edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
  Mesh mesh;
  for (const auto& [a, b] : edges) append(mesh, make_rod(sphere.positions[a], sphere.positions[b], wire, 5));
  return mesh;
}

Mesh make_grille(int columns, int rows, float bar, bool woven) {
  Mesh mesh;
  const auto add_bars = [&](int count, int crossings, bool upright) {
    for (int i = 0; i < count; ++i) {
      const float x = 2 * (share(i, count) + 0.5F / static_cast<float>(count)) - 1;
      std::vector<Vec3> curve;
      const int steps = woven ? 4 * crossings : 1;
      for (int k = 0; k <= steps; ++k) {
        const float y = 2 * share(k, steps) - 1;
        const float side = (i % 2 == 0) == upright ? 1.0F : -1.0F;
        const float z = woven ? side * bar * std::sin(kPi * (share(k, 4) + 0.0F)) : 0;
        curve.push_back(upright ? Vec3{x, y, z} : Vec3{y, x, z});
      }
      append(mesh, make_tube(curve, bar, 6, false));
    }
  };
  add_bars(columns, rows, true);
  add_bars(rows, columns, false);
  if (!woven) {  // a frame
    const float w = 2 * bar;
    for (const float side : {-1.0F, 1.0F}) {
      append(mesh, make_block({side, 0, 0}, {w, 1 + w, w}));
      append(mesh, make_block({0, side, 0}, {1 - w, w, w}));
    }
  }
  return mesh;
}

Mesh make_lattice(int cells, float rod) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i <= cells; ++i)
      for (int j = 0; j <= cells; ++j) {
        Vec3 centre;
        centre[(axis + 1) % 3] = 2 * share(i, cells) - 1;
        centre[(axis + 2) % 3] = 2 * share(j, cells) - 1;
        Vec3 half = grey(rod);
        half[axis] = 1 + rod;
        append(mesh, make_block(centre, half));
      }
  return mesh;
}

Mesh make_fence(RandomStream& random) {
  Mesh mesh;
  const int pickets = 6 + static_cast<int>(random.below(14));
  const float height = random.uniform(0.35F, 0.7F), gap = 2 / static_cast<float>(pickets);
  const float width = gap * random.uniform(0.2F, 0.4F);
  const bool pointed = random.below(2) == 0, leaning = random.below(3) == 0;
  for (int i = 0; i < pickets; ++i) {
    const float x = -1 + gap * (static_cast<float>(i) + 0.5F), lean = random.uniform(-0.12F, 0.12F);
    const float own = height * (leaning ? random.uniform(0.8F, 1.1F) : 1);
    Mesh picket;
    if (pointed)
      picket = placed(make_prism({{1, 0}, {0, 1}, {-1, 0}, {0, -1}}, own, 0, 0.75F, 1),
                      {width, 1, 0.5F * width}, {}, {});
    else
      picket = make_block({}, {width, own, 0.02F});
    append(mesh, placed(picket, grey(1), leaning ? turned_about({0, 0, 1}, lean) : Basis{}, {x, own, 0}));
  }
  for (const float y : {0.35F, 1.5F}) append(mesh, make_block({0, y * height, -0.045F}, {1, 0.05F, 0.022F}));
  return mesh;
}

Mesh make_blinds(int slats, float tilt) {
  Mesh mesh;
  const float pitch = 2 / static_cast<float>(slats);
  const Basis turn = turned_about({1, 0, 0}, tilt);
  for (int i = 0; i < slats; ++i)
    append(mesh, placed(make_block({}, {1, 0.006F, 0.46F * pitch}), grey(1), turn,
                        {0, -1 + pitch * (static_cast<float>(i) + 0.5F), 0}));
  for (const float x : {-0.7F, 0.7F}) append(mesh, make_rod({x, -1, 0}, {x, 1, 0}, 0.006F, 5));
  append(mesh, make_block({0, 1.02F, 0}, {1.02F, 0.03F, 0.05F}));
  return mesh;
}

Mesh make_ladder(int rungs) {
  Mesh mesh;
  for (const float x : {-0.25F, 0.25F}) append(mesh, make_rod({x, -1, 0}, {x, 1, 0}, 0.03F, 8));
  for (int i = 0; i < rungs; ++i) {
    const float y = -0.9F + 1.8F * share(i, std::max(1, rungs - 1));
    append(mesh, make_rod({-0.25F, y, 0}, {0.25F, y, 0}, 0.02F, 8));
  }
  return mesh;
}

}  // namespace ld
