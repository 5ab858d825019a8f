// Plain versions of the two families: balls, boxes, rings and blobs of five materials in a bare room or on
// bare ground. They need less training to denoise.
#pragma once

#include "core/random.h"
#include "render/trace/scene.h"

namespace ld {

/// Walls, lamps, camera and objects. Returns the index of the first object that is not part of the room.
size_t build_simple_room(Scene& scene, int objects, RandomStream& random);

/// Sky, ground, camera and objects. Returns the index of the first object that is not ground.
size_t build_simple_outdoors(Scene& scene, int objects, RandomStream& random);

}  // namespace ld
