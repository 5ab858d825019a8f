// Putting meshes together: shading normals, joining, measuring.
#pragma once

#include "render/geometry/mesh.h"

namespace ld {

/// Gives every corner the area-weighted mean normal of the triangles around its place that lie within
/// `crease` radians of its own (0: flat, pi: smooth everywhere). Places count as one when their coordinates
/// are equal bit for bit, so seams of texture coordinates do not show. Positions that need two normals are
/// doubled; triangles with two corners in one place are dropped.
void shade(Mesh& mesh, float crease);

/// Adds the triangles of `other`. Where one of the two is flat it is shaded flat first; texture coordinates
/// are kept when both have them (an empty mesh takes whatever comes).
void append(Mesh& mesh, Mesh other);

struct Bounds {
  Vec3 low, high;
  Vec3 centre() const { return 0.5F * (low + high); }
};
/// Of at least one position.
Bounds bounds_of(const std::vector<Vec3>& positions);

/// The largest distance of a position from `centre`.
float radius_around(const std::vector<Vec3>& positions, Vec3 centre);

/// The rotation by `angle` radians about the unit vector `axis` (Rodrigues).
Basis turned_about(Vec3 axis, float angle);

/// The mesh after place().
Mesh placed(Mesh mesh, Vec3 scale, const Basis& orientation, Vec3 translation);
Mesh moved(Mesh mesh, Vec3 translation);

}  // namespace ld
