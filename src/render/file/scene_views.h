// Many views of one scene file: its own cameras first, then places around them.
#pragma once

#include <cstdint>
#include <string>

#include "render/file/scene_file.h"
#include "render/file/scene_file_config.h"
#include "render/trace/prepared_scene.h"

namespace ld {

struct SceneView {
  Camera camera;
  FrameTimes times;
  float distance = 1;    // to what the camera looks at, scene units along its axis
  std::string name;      // for people: "camera Front", "view, defocus"
  int file_camera = -1;  // which of the file's the camera is, untouched
};

/// View number `frame`: a pure function of the arguments. `look` is the scene at config.time; views from
/// inside of things, from behind a wall and past everything are tried again.
SceneView choose_view(const SceneFile& file, const SceneFileConfig& config, const PreparedScene& look,
                      uint64_t seed, uint32_t frame, int width, int height);

/// A camera that shows all of the bounds, from above and to the right of +z.
Camera framing_camera(const Bounds& bounds, int width, int height);

/// Adds what the configuration wants beside the file's own objects and lights: probe or sky, ground.
void furnish(Scene& scene, const SceneFile& file, const SceneFileConfig& config,
             const std::optional<Probe>& probe);

/// What to multiply all light with so that the median luminance of the picture is 0.25; 1 for a black one.
float automatic_exposure(const PreparedScene& scene, const Camera& camera, uint64_t seed);

}  // namespace ld
