#include "render/random/random_scene.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "render/random/outdoors.h"
#include "render/random/random_materials.h"
#include "render/random/random_motion.h"
#include "render/random/rooms.h"
#include "render/random/simple_scenes.h"

namespace ld {
namespace {

/// Every object from `first` on is a model of its own.
std::vector<Placed> one_by_one(const Scene& scene, size_t first) {
  std::vector<Placed> models;
  for (size_t i = first; i < scene.objects.size(); ++i)
    models.push_back({i, i + 1, bounds_of(scene.objects[i].mesh.positions), false});
  return models;
}

/// One of the kinds whose names are chosen, each as often as the others.
template <class Kind>
const Kind& choose(const std::vector<Kind>& kinds, const std::vector<std::string>& chosen,
                   RandomStream& random) {
  std::vector<const Kind*> candidates;
  for (const Kind& kind : kinds)
    if (chosen.empty() || std::find(chosen.begin(), chosen.end(), kind.name) != chosen.end())
      candidates.push_back(&kind);
  return *candidates.at(random.below(static_cast<uint32_t>(candidates.size())));
}

template <class Kind>
std::vector<std::string> names_of(const std::vector<Kind>& kinds) {
  std::vector<std::string> names;
  for (const Kind& kind : kinds) names.emplace_back(kind.name);
  return names;
}

void check_counts(const std::vector<int64_t>& counts, const std::string& name, const char* key) {
  if (counts.size() != 2)
    fail_usage("{}: scenes.{}: expected two numbers, [fewest, most], found {}", name, key, counts.size());
  if (counts[0] > counts[1])
    fail_usage("{}: scenes.{}: expected [fewest, most], found [{}, {}]; swap them", name, key, counts[0],
               counts[1]);
}

void build_full(SceneBuilder& builder, const SceneConfig& config, bool indoor, int objects) {
  RandomStream& random = builder.random;
  if (indoor) {
    const RoomKind& room = choose(room_kinds(), config.rooms, random);
    room.build(builder, objects);
    builder.scene.name = std::string("indoor, ") + room.name;
  } else {
    const BackdropKind& backdrop = choose(backdrop_kinds(), config.backdrops, random);
    backdrop.build(builder);
    builder.scene.name = std::string("outdoor, ") + backdrop.name;
  }
  const int already = builder.count();
  add_random_models(builder, indoor ? objects : already + objects, indoor ? 0.2 : 0.15, indoor ? 0.7F : 1.2F);
}

}  // namespace

std::vector<std::string> SceneConfig::room_names() {
  return names_of(room_kinds());
}

std::vector<std::string> SceneConfig::backdrop_names() {
  return names_of(backdrop_kinds());
}

void finish_scene_config(SceneConfig& config, const std::string& name, const std::filesystem::path& folder) {
  check_counts(config.objects, name, "objects");
  if (!config.outdoor_objects.empty()) check_counts(config.outdoor_objects, name, "outdoor_objects");
  for (std::string* path : {&config.meshes, &config.textures, &config.probes})
    if (!path->empty() && std::filesystem::path(*path).is_relative())
      *path = (folder / *path).lexically_normal().string();
  const std::string found = shared_assets(config.meshes, config.textures, config.probes)->checksum();
  if (!config.files.empty() && config.files != found)
    fail(
        "{}: scenes.files: expected files with the checksum {}, found {}; restore the folders or leave the "
        "key out",
        name, config.files, found.empty() ? "no folders" : found);
  config.files = found;
}

Scene random_scene(const SceneConfig& config, uint64_t seed, uint32_t frame, uint32_t attempt, int width,
                   int height) {
  const RandomStream layout(seed, RandomPurpose::scene, frame, attempt, kLayoutStream);
  SceneBuilder builder(layout, shared_assets(config.meshes, config.textures, config.probes),
                       config.own_files);
  RandomStream& random = builder.random;
  Scene& scene = builder.scene;
  scene.camera.width = width;
  scene.camera.height = height;
  // Frame by frame the rounded count of rooms grows by the share: any run of frames holds its share of them.
  const bool indoor = std::floor((frame + 1.0) * config.indoor) > std::floor(frame * config.indoor);
  const std::vector<int64_t>& range =
      indoor || config.outdoor_objects.empty() ? config.objects : config.outdoor_objects;
  const auto span = static_cast<uint32_t>(std::max<int64_t>(0, range[1] - range[0]));
  const int objects = static_cast<int>(range[0]) + static_cast<int>(random.below(span + 1));
  const bool defocus = chance(random, config.defocus), motion_blur = chance(random, config.motion_blur);
  if (config.variety == "simple") {
    const size_t first =
        indoor ? build_simple_room(scene, objects, random) : build_simple_outdoors(scene, objects, random);
    builder.placed = one_by_one(scene, first);
    scene.name = indoor ? "indoor" : "outdoor";
  } else {
    build_full(builder, config, indoor, objects);
  }
  scene.camera.focus_distance = random_focus(scene, builder.placed, random);
  // How far the background blurs, as a share of the picture's height; what is very near, not beyond a tenth.
  const float blur = log_uniform(random, 0.006F, 0.04F) * static_cast<float>(height);
  if (defocus) {
    Camera& camera = scene.camera;
    camera.lens_radius = blur * camera.focus_distance / camera.focal_pixels();
    const float near = std::abs(camera.circle_of_confusion(0.8F));
    camera.lens_radius *= std::min(1.0F, 0.1F * static_cast<float>(height) / std::max(near, 1e-6F));
  }
  if (motion_blur) add_random_motion(scene, builder.placed, config, random);
  if (defocus) scene.name += ", defocus";
  if (motion_blur) scene.name += ", motion blur";
  return std::move(scene);
}

std::unique_ptr<PreparedScene> first_sound_draft(const std::function<Scene(uint32_t attempt)>& draft,
                                                 uint64_t seed, uint32_t frame,
                                                 std::vector<DraftFault>* rejected) {
  constexpr uint32_t kAttempts = 24;  // then the last draft has to do
  for (uint32_t attempt = 0;; ++attempt) {
    auto scene = std::make_unique<PreparedScene>(draft(attempt));
    RandomStream random(seed, RandomPurpose::scene, frame, attempt, kExposureStream);
    const DraftLook look = look_at_draft(*scene, log_uniform(random, 0.17F, 0.5F), seed, frame, attempt);
    if (look.fault != DraftFault::none && attempt + 1 < kAttempts) {
      if (rejected != nullptr) rejected->push_back(look.fault);
      continue;
    }
    scene->scale_lights(look.exposure);
    return scene;
  }
}

std::unique_ptr<PreparedScene> prepare_random_scene(const SceneConfig& config, uint64_t seed, uint32_t frame,
                                                    int width, int height,
                                                    std::vector<DraftFault>* rejected) {
  return first_sound_draft(
      [&](uint32_t attempt) { return random_scene(config, seed, frame, attempt, width, height); }, seed,
      frame, rejected);
}

}  // namespace ld
