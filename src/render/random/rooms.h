// Eight kinds of rooms, as the indoor scenes of [MH20] have.
#pragma once

#include "render/random/scene_builder.h"

namespace ld {

struct RoomKind {
  const char* name;
  /// Walls, windows, fixtures, furniture, lights and the camera; at most `count` models. Sets the spots that
  /// random models may fill, and the height up to which they may hover.
  void (*build)(SceneBuilder& builder, int count);
};

const std::vector<RoomKind>& room_kinds();

// rooms_home.cpp
void build_living_room(SceneBuilder& builder, int count);
void build_kitchen(SceneBuilder& builder, int count);
void build_attic(SceneBuilder& builder, int count);
void build_loft(SceneBuilder& builder, int count);
// rooms_public.cpp
void build_office(SceneBuilder& builder, int count);
void build_gallery(SceneBuilder& builder, int count);
void build_corridor(SceneBuilder& builder, int count);
void build_warehouse(SceneBuilder& builder, int count);

}  // namespace ld
