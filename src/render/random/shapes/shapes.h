// Generators of triangle meshes: solids, surfaces of revolution, tubes, lattices, sheets, plants, rocks. What
// is said to be closed is watertight with its normals outwards; sheets and leaves are open surfaces seen from
// both sides. Lengths are of order one; model.h brings shapes to unit radius. +y is up.
#pragma once

#include <functional>
#include <vector>

#include "core/random.h"
#include "render/geometry/mesh.h"

namespace ld {

inline float share(int i, int count) {
  return static_cast<float>(i) / static_cast<float>(count);
}

/// Edges that bend more than this stay sharp (radians, 40 degrees).
constexpr float kCrease = 0.7F;

// --- building blocks (surfaces.cpp)

/// The points point(i, j), 0 <= i <= columns, 0 <= j <= rows, as a surface whose front is along d/di x d/dj.
/// Texture coordinates i / columns, j / rows. A surface that closes upon itself repeats points bit for bit.
Mesh make_surface(int columns, int rows, float crease, const std::function<Vec3(int i, int j)>& point);
/// Closed. Turns the profile (x the radius, y the height), which begins and ends on the axis and has the
/// inside on its left when seen with the radius to the right, about the y axis.
Mesh make_lathe(const std::vector<Vec2>& profile, int around, float crease = kCrease);
/// Closed. Lifts an outline, counter-clockwise as seen from above (its y is -z in space) and visible as a
/// whole from the origin, from y = -half_height to half_height; the top is turned by `twist` radians and
/// scaled by `taper`.
Mesh make_prism(const std::vector<Vec2>& outline, float half_height, float twist, float taper, int rows);
/// A smooth curve through the points (Catmull-Rom), `steps` points a span; closed curves run back to the
/// first.
std::vector<Vec3> smooth_curve(const std::vector<Vec3>& points, int steps, bool closed);
std::vector<Vec2> smooth_curve(const std::vector<Vec2>& points, int steps);
/// Closed. A tube along the curve; radius(t), t in [0, 1] along it. Capped, or a ring when the curve is
/// closed.
Mesh make_tube(const std::vector<Vec3>& curve, const std::function<float(float)>& radius, int sides,
               bool closed);
Mesh make_tube(const std::vector<Vec3>& curve, float radius, int sides, bool closed);
/// Closed. The box around `centre`, flat, with texture coordinates on each face.
Mesh make_block(Vec3 centre, Vec3 half);
/// Closed. A straight rod.
Mesh make_rod(Vec3 from, Vec3 to, float radius, int sides);

// --- solids (solids.cpp), all closed

/// Radius 1 at the bottom, `top` at the top; bevelled edges.
Mesh make_cylinder(float half_height, float top, int around);
Mesh make_capsule(float half_length, float radius, int around);
Mesh make_rounded_box(Vec3 half, float radius);
/// `points` tips at radius 1, dents at `inner`.
std::vector<Vec2> star_outline(int points, float inner);
std::vector<Vec2> gear_outline(int teeth, float depth);
/// Faces: 4, 6, 8, 12 or 20.
Mesh make_platonic(int faces);
/// Barr 1981, exponents 0.2 to 2.5.
Mesh make_superellipsoid(float north, float east, int cells);
Mesh make_supertoroid(float tube, float north, float east, int cells);
struct SuperFormula {
  float m = 4, n1 = 1, n2 = 1, n3 = 1;
};
/// Gielis 2003: the product of two superformulas.
Mesh make_supershape(const SuperFormula& around, const SuperFormula& upwards, int cells);
Mesh make_seashell(float turns, float growth, float ridges);

// --- level sets and cells (implicit.cpp), closed

/// The surface inside(p) = 0 in [-1, 1]^3, positive inside, by marching tetrahedra; cut off at the cube's
/// faces.
Mesh make_level_set(const std::function<float(Vec3)>& inside, int cells);
/// Unit cells where filled(x, y, z), 0 <= each < size; only faces to empty cells.
Mesh make_voxels(int x, int y, int z, const std::function<bool(int, int, int)>& filled);

// --- tubes and lattices (wires.cpp, lattices.cpp), closed

Mesh make_helix(float turns, float radius, float height, float wire);
Mesh make_torus_knot(int p, int q, float tube);
/// A tangle of cables through random points.
Mesh make_cables(RandomStream& random, int count);
Mesh make_chain(RandomStream& random, int links);
Mesh make_rope(RandomStream& random);
/// The edges of a sphere of triangles as wires.
Mesh make_wire_sphere(int levels, float wire);
/// A grille in the xy plane: `columns` by `rows` bars, flat or woven.
Mesh make_grille(int columns, int rows, float bar, bool woven);
/// A block of rods in all three directions.
Mesh make_lattice(int cells, float rod);
Mesh make_fence(RandomStream& random);
Mesh make_blinds(int slats, float tilt);
Mesh make_ladder(int rungs);

// --- sheets (cloth.cpp), open

/// Hangs from y = 1 to y = -1.
Mesh make_curtain(RandomStream& random);
/// Lies over something round or square and falls in folds around it.
Mesh make_draped_sheet(RandomStream& random);
Mesh make_flag(RandomStream& random);
Mesh make_crumpled_sheet(RandomStream& random);
Mesh make_ribbon(RandomStream& random);

// --- nature (rocks.cpp closed; foliage.cpp: leaves open, stems closed)

Mesh make_rock(RandomStream& random);
Mesh make_crystals(RandomStream& random);
Mesh make_terrain_block(RandomStream& random);
/// A blade from the origin along +y that bends towards +z, `width` to each side at its widest, length 1.
/// The edges lie `fold` times the width below the middle.
Mesh make_leaf(float width, float bend, float fold, int rows);
struct Plant {
  Mesh leaves, stems;
};
Plant make_grass(RandomStream& random);
Plant make_potted_plant(RandomStream& random);
Plant make_fern(RandomStream& random);
Plant make_bush(RandomStream& random);
Plant make_tree(RandomStream& random);
Plant make_flower(RandomStream& random);

}  // namespace ld
