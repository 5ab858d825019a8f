// Seeded random scenes of two families, after the random scenes of [MH20] (Munkberg and Hasselgren 2020,
// section 4): rooms of eight kinds lit by up to four area lights, a point light and what falls in through
// windows, and objects on a backdrop under a sky or probe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/config_visitor.h"
#include "render/random/draft_check.h"
#include "render/trace/prepared_scene.h"

namespace ld {

// Streams of one draft: index c of RandomStream(seed, scene, frame, attempt, c).
constexpr uint32_t kLayoutStream = 0, kPilotStream = 1, kExposureStream = 2;

struct SceneConfig {
  double indoor = 0.5;                      // share of rooms; evenly spread over the frames
  double defocus = 0.5;                     // share of scenes with a thin lens instead of a pinhole
  double motion_blur = 0.5;                 // share of scenes with moving objects and an open shutter
  std::vector<int64_t> objects = {10, 30};  // fewest and most models in a scene
  std::vector<int64_t> outdoor_objects;     // the same outdoors; empty: as `objects`
  double turning = 0.5;                     // share of the moving objects that turn
  double camera_motion = 0.25;              // share of the scenes with motion blur whose camera moves too
  std::string variety = "full";             // simple: four shapes of five materials in bare rooms and plains
  std::vector<std::string> rooms;           // kinds of room to choose from; empty: all
  std::vector<std::string> backdrops;       // kinds of backdrop to choose from; empty: all
  std::string meshes;                       // folder of the user's own meshes; empty: none
  std::string textures;                     // folder of the user's own pictures; empty: none
  std::string probes;                       // folder of the user's own probes; empty: none
  double own_files = 0.5;  // share of models, textures and skies that come from these folders
  std::string files;       // checksum of the folders' files; filled when the recipe is read

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("indoor", indoor, Range{0, 1});
    v.field("defocus", defocus, Range{0, 1});
    v.field("motion_blur", motion_blur, Range{0, 1});
    v.field("objects", objects, Range{1, 1000});
    v.field("outdoor_objects", outdoor_objects, Range{1, 1000});
    v.field("turning", turning, Range{0, 1});
    v.field("camera_motion", camera_motion, Range{0, 1});
    v.field("variety", variety, Choices{"full", "simple"});
    v.field("rooms", rooms, room_names());
    v.field("backdrops", backdrops, backdrop_names());
    v.field("meshes", meshes);
    v.field("textures", textures);
    v.field("probes", probes);
    v.field("own_files", own_files, Range{0, 1});
    v.field("files", files);
  }

  static std::vector<std::string> room_names();
  static std::vector<std::string> backdrop_names();
};

/// Checks what one field cannot know of another. Folders go from `folder` when they are relative; their
/// checksum is computed, or compared with the one given. Throws UsageError; Error when a folder is missing or
/// holds other files.
void finish_scene_config(SceneConfig& config, const std::string& name, const std::filesystem::path& folder);

/// Draft number `attempt` of a frame's scene; a pure function of the arguments.
Scene random_scene(const SceneConfig& config, uint64_t seed, uint32_t frame, uint32_t attempt, int width,
                   int height);

/// The first draft without a fault (draft_check.h), its lights scaled so that the median luminance of the
/// picture lies about between 0.17 and 0.5. `rejected`, when given, receives the faults of the drafts before
/// it.
std::unique_ptr<PreparedScene> first_sound_draft(const std::function<Scene(uint32_t attempt)>& draft,
                                                 uint64_t seed, uint32_t frame,
                                                 std::vector<DraftFault>* rejected = nullptr);

/// The scene of a frame, of random_scene()'s drafts.
std::unique_ptr<PreparedScene> prepare_random_scene(const SceneConfig& config, uint64_t seed, uint32_t frame,
                                                    int width, int height,
                                                    std::vector<DraftFault>* rejected = nullptr);

}  // namespace ld
