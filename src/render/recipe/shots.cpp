#include "render/recipe/shots.h"

#include <cmath>

#include "core/error.h"
#include "render/random/random_materials.h"
#include "render/random/room_parts.h"
#include "render/random/shapes/shapes.h"
#include "render/random/stages.h"

namespace ld {
namespace {

// As kPathStream, for all else that is random in a shot.
constexpr uint32_t kShotStream = kPathStream + 1;

// What crosses a still picture while the shutter is open would leave the picture within a few frames.
constexpr float kCalmer = 0.5F;

/// What makes the shots of one sequence.
struct Director {
  const Recipe& recipe;
  uint32_t number;
  RandomStream random;

  int64_t length() const { return recipe.sequence.length; }
  float speed() const { return static_cast<float>(recipe.sequence.speed); }

  Scene random_set(const SceneConfig& config, uint32_t scene) const {
    return prepare_random_scene(config, recipe.seed, scene, recipe.width(), recipe.height())->scene();
  }
  Scene random_set() const { return random_set(recipe.scenes, number); }
  /// Its objects go as slowly as in a flight.
  Scene calm_set() const {
    Scene scene = random_set();
    for (Object& object : scene.objects) object.motion = part_of(object.motion, 0, kCalmer);
    return scene;
  }

  template <class Make>
  Scene stage(const Make& make) const {
    return first_sound_draft(
               [&](uint32_t attempt) {
                 return make(StageDraft{recipe.scenes, recipe.seed, number, attempt, recipe.width(),
                                        recipe.height(), length()});
               },
               recipe.seed, number)
        ->scene();
  }

  /// The flight of `fly`.
  SequencePlan flown(Scene scene, uint32_t scene_number, float share = 1) const {
    RandomStream path(recipe.seed, RandomPurpose::scene, scene_number, 0, kPathStream);
    const float distance = scene.camera.focus_distance;
    return plan_sequence(std::move(scene), distance, length(), kCalmer * share * speed(), path);
  }

  /// The camera goes evenly, by `step` in its own axes and by `angle` a frame; objects at their speed.
  SequencePlan steady(Scene scene, Vec3 step, float angle) const {
    for (Object& object : scene.objects) object.motion = part_of(object.motion, 0, speed());
    Scene whole = scene;
    for (Object& object : whole.objects)
      object.motion = part_of(object.motion, 0, static_cast<float>(length()));
    const Camera start = scene.camera.at(0);
    CameraPath path = steady_path(PreparedScene(std::move(whole)), start, start.axes.to_world(step) * speed(),
                                  angle * speed(), length());
    return {std::move(scene), std::move(path)};
  }

  /// `low` to `high`, to either side.
  float either(float low, float high) {
    const float size = random.uniform(low, high);
    return chance(random, 0.5) ? size : -size;
  }
  /// A frame in the middle third.
  int64_t about_half() {
    return length() / 3 + static_cast<int64_t>(random.below(static_cast<uint32_t>(length() / 3 + 1)));
  }
};

Shot one_take(SequencePlan plan) {
  Shot shot;
  shot.takes.push_back({0, std::move(plan)});
  return shot;
}

Shot fly_shot(Director& director) {
  return one_take(director.flown(director.random_set(), director.number));
}

Shot cut_shot(Director& director) {
  constexpr uint32_t kOther = 1U << 30;  // recipes have fewer scenes
  Shot shot = fly_shot(director);
  const uint32_t other = director.number + kOther;
  shot.takes.push_back({std::max<int64_t>(1, director.about_half()),
                        director.flown(director.random_set(director.recipe.scenes, other), other)});
  return shot;
}

Shot light_off_shot(Director& director) {
  const Recipe& recipe = director.recipe;
  SceneConfig config = recipe.scenes;
  config.indoor = 1;
  // Dusk: it is the lamps that light the room.
  Scene scene = first_sound_draft(
                    [&](uint32_t attempt) {
                      Scene draft = random_scene(config, recipe.seed, director.number, attempt,
                                                 recipe.width(), recipe.height());
                      scale_environment(draft, 0.1F);
                      return draft;
                    },
                    recipe.seed, director.number)
                    ->scene();
  Shot shot = one_take(director.flown(std::move(scene), director.number, 0.3F));
  shot.lamps_off = director.about_half();
  return shot;
}

Shot door_shot(Director& director) {
  const float angle = chance(director.random, 0.5) ? 0 : director.either(0.002F, 0.008F);
  Shot shot = one_take(director.steady(director.stage(door_stage), {}, angle));
  shot.takes[0].plan.begin = kDoorBegins;
  return shot;
}

Mesh random_thing(RandomStream& random) {
  switch (random.below(4)) {
    case 0:
      return make_sphere(4);
    case 1:
      return make_rounded_box({0.7F, 0.55F, 0.6F}, 0.08F);
    case 2:
      return make_torus(0.35F, 48, 24);
    default:
      return make_torus_knot(2, 3, 0.12F);
  }
}

Shot enter_shot(Director& director) {
  Scene scene = director.calm_set();
  RandomStream& random = director.random;
  const Camera camera = scene.camera.at(0);
  const auto seen = PreparedScene(scene).trace({camera.position, -camera.axes.z}, 0);
  const float free = seen ? std::min(seen->distance, 2 * camera.focus_distance) : camera.focus_distance;
  constexpr int kThings = 3;
  for (int i = 0; i < kThings; ++i) {
    const float depth = free * random.uniform(0.35F, 0.75F),
                half_height = depth * std::tan(0.5F * camera.fov),
                half_width =
                    half_height * static_cast<float>(camera.width) / static_cast<float>(camera.height),
                radius = half_height * random.uniform(0.15F, 0.35F),
                side = chance(random, 0.5) ? 1.0F : -1.0F, up = random.uniform(-0.6F, 0.6F) * half_height;
    // Just outside at first, its ball behind the plane of the picture's edge, or entering some frames later.
    const float outside = 1.1F * radius * std::hypot(depth, half_width) / depth,
                later = 0.4F * static_cast<float>(i), start = (1 + later) * half_width + outside,
                way = (2.2F + later) * half_width / static_cast<float>(director.length());
    Object thing;
    thing.mesh = random_thing(random);
    const Vec3 at = camera.position + camera.axes.to_world({side * start, up, -depth});
    const float size = radius / radius_around(thing.mesh.positions, {});
    place(thing.mesh, grey(size), random_rotation(random), at);
    thing.motion.translation = camera.axes.x * (-side * way);
    const float u = random.uniform(), v = random.uniform();
    thing.motion.axis = sample_sphere(u, v);
    thing.motion.angle = random.uniform(-0.15F, 0.15F);
    thing.motion.pivot = at;
    thing.material = static_cast<int>(scene.materials.size());
    scene.materials.push_back(random_material(random, radius));
    scene.objects.push_back(std::move(thing));
  }
  const float aside = director.either(0.001F, 0.005F) * free;
  return one_take(director.steady(std::move(scene), {aside, 0, 0}, 0));
}

Shot dolly_shot(Director& director) {
  Scene scene = director.calm_set();
  const Camera camera = scene.camera.at(0);
  const auto seen = PreparedScene(scene).trace({camera.position, -camera.axes.z}, 0);
  const float free = seen ? seen->distance : camera.focus_distance;
  return one_take(
      director.steady(std::move(scene), {0, 0, -0.5F * free / static_cast<float>(director.length())}, 0));
}

Shot turn_shot(Director& director) {
  const float angle = director.either(1.5F, 3.5F) * kPi / 180;
  return one_take(director.steady(director.calm_set(), {}, angle));
}

Shot mirror_shot(Director& director) {
  const float aside = director.either(0.015F, 0.05F);
  return one_take(director.steady(director.stage(mirror_stage), {aside, 0, 0}, 0));
}

Shot thin_shot(Director& director) {
  const float aside = director.either(0.015F, 0.05F);
  return one_take(director.steady(director.stage(thin_stage), {aside, 0, 0}, 0));
}

Shot still_shot(Director& director) {
  Scene scene = director.random_set();
  for (Object& object : scene.objects) object.motion = {};
  return one_take(director.steady(std::move(scene), {}, 0));
}

struct ShotKind {
  const char* name;
  Shot (*make)(Director& director);
};
constexpr ShotKind kShotKinds[] = {
    {"fly", fly_shot},     {"cut", cut_shot},     {"light_off", light_off_shot}, {"door", door_shot},
    {"enter", enter_shot}, {"dolly", dolly_shot}, {"turn", turn_shot},           {"mirror", mirror_shot},
    {"thin", thin_shot},   {"still", still_shot}};

void dim_lamps(Scene& scene, float factor) {
  for (AreaLight& light : scene.lights) light.radiance *= factor;
  for (PointLight& light : scene.point_lights) light.intensity *= factor;
  for (DirectionalLight& light : scene.directional_lights) light.irradiance *= factor;
  for (Material& material : scene.materials)
    if (material.emission) {
      material.emission->colour_a *= factor;
      material.emission->colour_b *= factor;
    }
}

}  // namespace

std::vector<std::string> SequenceConfig::kind_names() {
  std::vector<std::string> names;
  for (const ShotKind& kind : kShotKinds) names.emplace_back(kind.name);
  return names;
}

Shot plan_shot(const Recipe& recipe, int64_t sequence) {
  const auto number = static_cast<uint32_t>(sequence);
  Director director = {recipe, number,
                       RandomStream(recipe.seed, RandomPurpose::scene, number, 0, kShotStream)};
  const std::string& name = recipe.sequence.kind_of(sequence);
  for (const ShotKind& kind : kShotKinds)
    if (name == kind.name) {
      Shot shot = kind.make(director);
      if (kind.make != fly_shot)
        for (Take& take : shot.takes) take.plan.scene.name += ", " + name;
      return shot;
    }
  fail_usage("sequence.kinds: no kind '{}'", name);
}

Scene shot_frame(const Shot& shot, int64_t position, float shutter) {
  const Take* take = &shot.takes[0];
  for (const Take& other : shot.takes)
    if (other.first <= position) take = &other;
  Scene scene = sequence_frame(take->plan, position - take->first, shutter);
  scene.cut = take->first > 0 && take->first == position;
  if (shot.lamps_off >= 0 && position >= shot.lamps_off) dim_lamps(scene, kEmergency);
  return scene;
}

}  // namespace ld
