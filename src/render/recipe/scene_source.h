// Where the frames of a data set come from.
#pragma once

#include <memory>

#include "render/recipe/recipe.h"
#include "render/trace/prepared_scene.h"

namespace ld {

class SceneSource {
 public:
  virtual ~SceneSource() = default;

  /// The scene of a frame of the recipe, its camera set up: a pure function of recipe and frame. Safe to call
  /// from several threads.
  virtual std::unique_ptr<PreparedScene> prepare(int64_t frame) const = 0;
};

/// Random scenes, views of a scene file, or sequences of either, as the recipe says. Throws Error when the
/// scene file cannot be read.
std::unique_ptr<SceneSource> make_scene_source(const Recipe& recipe);

}  // namespace ld
