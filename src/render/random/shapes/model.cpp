#include "render/random/shapes/model.h"

#include <algorithm>

#include "render/geometry/mesh_tools.h"

namespace ld {

void add_part(Model& model, Stuff stuff, Mesh mesh, bool closed) {
  for (Part& part : model)
    if (part.stuff == stuff && part.closed == closed) return append(part.mesh, std::move(mesh));
  model.push_back({std::move(mesh), stuff, closed});
}

void add_model(Model& model, const Model& other, Vec3 scale, const Basis& orientation, Vec3 translation) {
  for (const Part& part : other)
    add_part(model, part.stuff, placed(part.mesh, scale, orientation, translation), part.closed);
}

void place(Model& model, Vec3 scale, const Basis& orientation, Vec3 translation) {
  for (Part& part : model) place(part.mesh, scale, orientation, translation);
}

Bounds bounds_of(const Model& model) {
  Bounds all = bounds_of(model.at(0).mesh.positions);
  for (const Part& part : model) {
    const Bounds own = bounds_of(part.mesh.positions);
    for (int i = 0; i < 3; ++i) {
      all.low[i] = std::min(all.low[i], own.low[i]);
      all.high[i] = std::max(all.high[i], own.high[i]);
    }
  }
  return all;
}

void fit_to_unit(Model& model) {
  const Vec3 centre = bounds_of(model).centre();
  float radius = 0;
  for (const Part& part : model) radius = std::max(radius, radius_around(part.mesh.positions, centre));
  place(model, grey(1 / radius), {}, centre * (-1 / radius));
}

}  // namespace ld
