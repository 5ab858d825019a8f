// Seeded random scenes of two families, after the random scenes of [MH20] (Munkberg and Hasselgren 2020,
// section 4): rooms lit by small area lights, and objects on a ground under a sky.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/config_visitor.h"
#include "render/prepared_scene.h"

namespace ld {

struct SceneConfig {
  double indoor = 0.5;                      // share of rooms; evenly spread over the frames
  double defocus = 0.5;                     // share of scenes with a thin lens instead of a pinhole
  double motion_blur = 0.5;                 // share of scenes with moving objects and an open shutter
  std::vector<int64_t> objects = {10, 30};  // fewest and most in a scene

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("indoor", indoor, Range{0, 1});
    v.field("defocus", defocus, Range{0, 1});
    v.field("motion_blur", motion_blur, Range{0, 1});
    v.field("objects", objects, Range{1, 1000});
  }
};

/// Draft number `attempt` of a frame's scene; a pure function of the arguments.
Scene random_scene(const SceneConfig& config, uint64_t seed, uint32_t frame, uint32_t attempt, int width,
                   int height);

/// The scene of a frame: the first draft with something to see (a camera neither against a surface nor facing
/// the void), its lights scaled so that the median luminance of the picture lies between 0.1 and 0.5.
std::unique_ptr<PreparedScene> prepare_random_scene(const SceneConfig& config, uint64_t seed, uint32_t frame,
                                                    int width, int height);

}  // namespace ld
