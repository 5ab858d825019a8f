// Walls with windows and doors, and putting things along them.
#pragma once

#include <array>

#include "render/random/random_lights.h"
#include "render/random/scene_builder.h"

namespace ld {

/// A rectangle seen from inside a room: `along` to the right and `up`, unit vectors, cross(along, up) into
/// the room.
struct Wall {
  Vec3 corner, along, up;
  float width = 0, height = 0;

  Vec3 normal() const { return cross(along, up); }
  /// `s` along, `t` up, `lift` into the room.
  Vec3 at(float s, float t, float lift = 0) const { return corner + along * s + up * t + normal() * lift; }
  /// The turn about +y that makes a model's +z point into the room.
  float turn() const { return std::atan2(normal().x, normal().z); }
};

/// A hole in a wall, from its corner.
struct Opening {
  float s0, t0, s1, t1;
};

enum WallIndex { kBack, kFront, kLeft, kRight, kFloor, kCeiling };  // at -z, +z, -x, +x
/// The six sides of the room [-half.x, half.x] x [0, height] x [-half.z, half.z].
std::array<Wall, 6> box_walls(Vec3 half, float height);

/// The wall around its openings, which are `depth` deep.
void add_wall(SceneBuilder& builder, const Wall& wall, const std::vector<Opening>& openings, int material,
              float depth = 0.2F);
/// Bars across an opening: `columns` by `rows` panes.
void add_window_frame(SceneBuilder& builder, const Wall& wall, const Opening& hole, int columns, int rows);
/// Curtains to both sides or blinds in front; now and then nothing.
void dress_window(SceneBuilder& builder, const Wall& wall, const Opening& hole);
void add_door(SceneBuilder& builder, const Wall& wall, float s);
/// A window of random size in the wall, with its frame; returns the hole for add_wall.
Opening random_window(SceneBuilder& builder, const Wall& wall, float sill);

/// A model in metres with its back against the wall.
void set_against(SceneBuilder& builder, const Wall& wall, float s, Model model, float gap = 0.03F);
/// On the wall, its middle at (s, t).
void hang(SceneBuilder& builder, const Wall& wall, float s, float t, Model model);
/// Lets things stand on the model placed last.
void make_spot(SceneBuilder& builder, float smallest, float largest);
void make_spot(SceneBuilder& builder, Vec3 low, Vec3 high, float smallest, float largest);
/// Lets things up to the size `largest` stand on the floor of the room of the size 2 * half.
void set_floor_spot(SceneBuilder& builder, Vec3 half, float height, float largest);

/// A camera within `region` that looks at something in it across some distance, at no thing's inside. `fov`
/// between the two.
void place_camera(SceneBuilder& builder, const Bounds& region, float nearest, float fov_low, float fov_high);

/// Multiplies the light from outside.
void scale_environment(Scene& scene, float factor);

}  // namespace ld
