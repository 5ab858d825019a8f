// The sections of a recipe (recipe.h) that turn a scene file or a sequence of frames into a data set.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/config_visitor.h"

namespace ld {

/// Views of a scene in a file (scene_file.h). Frame i below the number of the file's cameras is camera i as
/// it stands; the others look from places around them, or around the whole scene when the file has no camera.
struct SceneFileConfig {
  std::string path;  // relative to the recipe; empty: random scenes
  std::string
      checksum;       // of the file, of what it refers to and of the probe; filled in when the recipe is read
  std::string probe;  // equirectangular picture (OpenImageIO) as the background, instead of the file's
  double probe_scale = 1;           // its radiance times this
  double probe_turn = 0;            // degrees counter-clockwise as seen from +y
  std::string background = "auto";  // without a probe; auto: a sky for files without any light, else black
  bool ground = false;              // a grey plane under the scene
  double exposure = 1;              // all light times this; 0: as the first view needs it
  bool file_cameras = true;         // false: only generated views
  double orbit = 30;                // degrees that generated views go around a camera's centre of interest
  double defocus = 0.5;             // share of generated views with a thin lens
  double motion_blur = 0.5;         // share of generated views with an open shutter
  int64_t animation = 0;            // which of the file's animations plays
  double time = 0;  // seconds into the animation: of the file's cameras and of a sequence's first frame
  double frame_time = 1.0 / 24;  // seconds between the frames of a sequence
  double shutter = 0.5;          // share of frame_time that the shutter is open

  bool used() const { return !path.empty(); }

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("path", path);
    v.field("checksum", checksum);
    v.field("probe", probe);
    v.field("probe_scale", probe_scale, Range{0, 1e6});
    v.field("probe_turn", probe_turn, Range{-360, 360});
    v.field("background", background, {"auto", "sky", "black"});
    v.field("ground", ground);
    v.field("exposure", exposure, Range{0, 1e6});
    v.field("file_cameras", file_cameras);
    v.field("orbit", orbit, Range{0, 180});
    v.field("defocus", defocus, Range{0, 1});
    v.field("motion_blur", motion_blur, Range{0, 1});
    v.field("animation", animation, Range{0, 1e6});
    v.field("time", time, Range{0, 1e6});
    v.field("frame_time", frame_time, Range{1e-6, 1e6});
    v.field("shutter", shutter, Range{0, 1});
  }
};

/// Finds the files from `folder` (paths become relative to the working folder, or absolute as they were), and
/// fills in the checksum. Throws Error for a file that is missing, UsageError when `checksum` was given and
/// differs.
void resolve(SceneFileConfig& config, const std::filesystem::path& folder);

}  // namespace ld
