// A model is what a scene places as one object: one or more meshes, each of a stuff that wants its own
// material.
#pragma once

#include <string>
#include <vector>

#include "core/random.h"
#include "render/geometry/mesh.h"

namespace ld {

/// What a part is made of. `any` leaves it open.
enum class Stuff { any, wood, metal, glass, cloth, leaf, stone, paper, screen, bulb, ceramic };

struct Part {
  Mesh mesh;
  Stuff stuff = Stuff::any;
  bool closed = true;  // else a sheet seen from both sides, which cannot be of glass
};

using Model = std::vector<Part>;

/// Adds the mesh to the part of this stuff, or as a new one.
void add_part(Model& model, Stuff stuff, Mesh mesh, bool closed = true);
/// Adds all parts of another model, placed.
void add_model(Model& model, const Model& other, Vec3 scale, const Basis& orientation, Vec3 translation);
void place(Model& model, Vec3 scale, const Basis& orientation, Vec3 translation);
/// Lowest and highest coordinates of all parts.
struct Bounds bounds_of(const Model& model);
/// Moves the middle of the bounds to the origin and scales to unit radius.
void fit_to_unit(Model& model);

enum class Family { solid, wire, sheet, plant, nature, furniture, fixture };

struct ModelKind {
  const char* name;
  Family family;
  bool upright;                         // stands on a floor; else it may be turned any way
  float likelihood;                     // beside the others
  Model (*make)(RandomStream& random);  // fitted to unit radius
};

/// All kinds, a fixed order.
const std::vector<ModelKind>& model_kinds();

}  // namespace ld
