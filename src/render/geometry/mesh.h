// Triangle meshes of the objects. Triangles are wound counter-clockwise as seen from outside.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/geometry/vec3.h"

namespace ld {

struct Mesh {
  std::vector<Vec3> positions;  // scene units
  std::vector<Vec3> normals;    // unit, one a position; empty: the triangles are flat
  std::vector<Vec2> uvs;        // empty, or one for each position; v runs upwards
  std::vector<std::array<uint32_t, 3>> triangles;
};

/// Unit sphere: an icosahedron whose triangles were quartered `levels` times (20 * 4^levels of them).
Mesh make_sphere(int levels);
/// The cube [-1, 1]^3, flat.
Mesh make_box();
/// Ring of radius 1 in the xz plane, the tube's radius `tube` below 1.
Mesh make_torus(float tube, int around, int across);
/// Unit sphere displaced along its normals by `amplitude` times fractal noise of `frequency` cells a unit.
Mesh make_blob(float amplitude, float frequency, int octaves, uint32_t seed, int levels);
/// The square [-size, size]^2 in the xz plane, facing +y, as cells^2 squares displaced in y by `amplitude`
/// times fractal noise of `frequency` cells a unit; flat when the amplitude is 0.
Mesh make_ground(float size, int cells, float amplitude, float frequency, uint32_t seed);
/// The parallelogram corner + s edge_u + t edge_v, s and t in [0, 1], facing cross(edge_u, edge_v).
Mesh make_parallelogram(Vec3 corner, Vec3 edge_u, Vec3 edge_v);

/// Scales along the mesh's axes (all above 0), turns them to `orientation`, moves by `translation`.
void place(Mesh& mesh, Vec3 scale, const Basis& orientation, Vec3 translation);

/// Turns every triangle and normal inside out (a room is a box seen from inside).
void turn_inside_out(Mesh& mesh);

}  // namespace ld
