// Random shapes, put where they do not run into each other.
#pragma once

#include <functional>

#include "core/random.h"
#include "render/trace/scene.h"

namespace ld {

/// Where objects may stand: their centre in [low, high], `floor(x, z)` beneath, `clear` units around the
/// camera free.
struct Stage {
  Vec3 low, high;
  std::function<float(float, float)> floor;
  Vec3 camera;
  float clear = 1;
  float smallest = 0.2F, largest = 0.8F;  // radius
  double floating = 0.3;                  // share that hovers instead of standing on the floor
};

/// Adds about `count` spheres, boxes, tori and blobs with a random material each (fewer when the stage is
/// full), behind the objects that the scene has.
void add_random_objects(Scene& scene, const Stage& stage, int count, RandomStream& random);

}  // namespace ld
