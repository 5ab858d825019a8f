// Backdrops of the outdoor scenes.
#pragma once

#include "render/random/scene_builder.h"

namespace ld {

struct BackdropKind {
  const char* name;
  /// Ground, what stands around, light and camera. Sets the floor and the spots that random models may fill.
  void (*build)(SceneBuilder& builder);
};

const std::vector<BackdropKind>& backdrop_kinds();

}  // namespace ld
