// Random materials for parts of models, walls and floors, by what they are made of.
#pragma once

#include "render/random/scene_builder.h"

namespace ld {

/// Adds a random material that suits the part and returns its index (mixed ones add three).
int add_material_of(SceneBuilder& builder, const Part& part);

enum class WallKind { wall, floor, ceiling, ground };
/// A material for something flat and large; patterns lie in the plane of `along` and `upwards`.
int add_wall_material(SceneBuilder& builder, WallKind kind, Vec3 along, Vec3 upwards);

}  // namespace ld
