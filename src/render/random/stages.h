// Rooms around one thing that happens in a sequence. An object's motion is its way in one frame. All have a
// pinhole camera and random furnishings.
#pragma once

#include "render/random/random_scene.h"

namespace ld {

struct StageDraft {
  const SceneConfig& config;
  uint64_t seed;
  uint32_t number, attempt;  // of the scene, and which draft of it
  int width, height;         // of the picture
  int64_t length;            // of the sequence, frames
};

/// A dim room with a door to a bright one, closed at frame 0, that opens by 70 to 100 degrees within `length`
/// less kDoorBegins frames.
Scene door_stage(const StageDraft& draft);
constexpr int kDoorBegins = 2;

/// A room with a large mirror, now and then also a polished floor, in which things move and turn.
Scene mirror_stage(const StageDraft& draft);

/// Wires, fences, grilles and plants in a row before a room.
Scene thin_stage(const StageDraft& draft);

}  // namespace ld
