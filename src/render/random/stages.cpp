#include "render/random/stages.h"

#include <cmath>

#include "render/random/model_materials.h"
#include "render/random/random_materials.h"
#include "render/random/room_parts.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

constexpr Vec3 kDown = {0, -1, 0};

struct Room {
  Vec3 half;
  float height;
  std::array<Wall, 6> walls;
};

SceneBuilder begin(const StageDraft& draft) {
  SceneBuilder builder(
      RandomStream(draft.seed, RandomPurpose::scene, draft.number, draft.attempt, kLayoutStream),
      shared_assets(draft.config.meshes, draft.config.textures, draft.config.probes), draft.config.own_files);
  builder.scene.camera.width = draft.width;
  builder.scene.camera.height = draft.height;
  return builder;
}

Room room_of(RandomStream& random) {
  const Vec3 half = {random.uniform(2.4F, 3.6F), 0, random.uniform(2.4F, 3.6F)};
  const float height = random.uniform(2.6F, 3.2F);
  return {half, height, box_walls(half, height)};
}

/// Its six sides, the back one with openings.
void add_sides(SceneBuilder& builder, const Room& room, const std::vector<Opening>& openings) {
  add_wall(builder, room.walls[kFloor], {},
           add_wall_material(builder, WallKind::floor, {0, 0, 1}, {1, 0, 0}));
  add_wall(builder, room.walls[kCeiling], {},
           add_wall_material(builder, WallKind::ceiling, {1, 0, 0}, {0, 0, 1}));
  const int paint = add_wall_material(builder, WallKind::wall, {1, 0, 0}, {0, 1, 0});
  add_wall(builder, room.walls[kBack], openings, paint);
  for (const WallIndex i : {kFront, kLeft, kRight}) add_wall(builder, room.walls[i], {}, paint);
  set_floor_spot(builder, room.half, room.height, 0.6F);
}

void look(SceneBuilder& builder, Vec3 from, Vec3 at, float fov) {
  Camera& camera = builder.scene.camera;
  camera.position = from;
  camera.axes = look_at(from, at, {0, 1, 0});
  camera.focus_distance = length(at - from);
  camera.fov = fov;
}

int count_of(const SceneConfig& config, RandomStream& random) {
  const auto span = static_cast<uint32_t>(config.objects[1] - config.objects[0]);
  return static_cast<int>(config.objects[0]) + static_cast<int>(random.below(span + 1));
}

/// A lamp under the ceiling at (x, z).
void add_ceiling_lamp(SceneBuilder& builder, float height, float x, float z, float side, float power) {
  add_area_light(builder, {x, height - 0.03F, z}, kDown, side, side, power, false);
}

void set_motion(Scene& scene, const Placed& model, const Motion& motion) {
  for (size_t i = model.first; i < model.last; ++i) scene.objects[i].motion = motion;
}

}  // namespace

Scene door_stage(const StageDraft& draft) {
  SceneBuilder builder = begin(draft);
  RandomStream& random = builder.random;
  const Room room = room_of(random);
  const float width = random.uniform(0.9F, 1.3F), height = 2.05F,
              s = random.uniform(0.6F, 2 * room.half.x - 0.6F - width), left = s - room.half.x,
              wall = -room.half.z;
  add_sides(builder, room, {{s, 0, s + width, height}});
  const Vec3 behind_half = {room.half.x, 0, 1.5F};
  for (Wall side : box_walls(behind_half, room.height)) {
    side.corner.z += wall - behind_half.z;
    if (dot(side.normal(), {0, 0, -1}) > 0.5F) continue;  // where the door is
    add_wall(builder, side, {}, add_wall_material(builder, WallKind::wall, side.along, side.up));
  }
  const float middle = left + 0.5F * width;
  const float bright = log_uniform(random, 6, 14);
  if (chance(random, 0.5))
    add_ceiling_lamp(builder, room.height, middle, wall - 1, 1, bright);
  else
    add_area_light(builder, {middle, 1.3F, wall - 2.9F}, {0, 0, 1}, 1.4F, 1.4F, bright, false);
  const float lamp_x = random.uniform(-0.5F, 0.5F) * room.half.x;
  add_ceiling_lamp(builder, room.height, lamp_x, 0.3F * room.half.z, 0.5F, 0.5F);

  // The door turns away from the camera about its left edge.
  const float depth = wall - 0.06F, total = random.uniform(70, 100) * kPi / 180;
  Model door;
  add_part(
      door, Stuff::wood,
      make_block({middle, 0.5F * height, depth}, {0.5F * width - 0.004F, 0.5F * height - 0.004F, 0.02F}));
  const Vec3 handle = {left + 0.88F * width, 1, depth + 0.06F};
  add_part(door, Stuff::metal, make_rod(handle, handle - Vec3{0.12F, 0, 0}, 0.012F, 8));
  builder.add(door, true);
  Motion opening;
  opening.angle = total / static_cast<float>(std::max<int64_t>(1, draft.length - kDoorBegins));
  opening.pivot = {left, 0, depth};
  set_motion(builder.scene, builder.placed.back(), opening);
  builder.occupancy.take({{left - 0.2F, 0, wall}, {left + width + 0.2F, height, wall + 1.2F}});

  const float x = random.uniform(-0.6F, 0.6F), y = random.uniform(1.1F, 1.8F),
              aside = random.uniform(0, 0.5F), fov = random.uniform(0.8F, 1.05F);
  look(builder, {x * room.half.x, y, 0.88F * room.half.z}, {(1 - aside) * middle, 1.1F, wall}, fov);
  add_random_models(builder, 1 + count_of(draft.config, random), 0.1, 0.9F);
  builder.scene.name = "stage";
  return std::move(builder.scene);
}

Scene mirror_stage(const StageDraft& draft) {
  SceneBuilder builder = begin(draft);
  RandomStream& random = builder.random;
  const Room room = room_of(random);
  add_sides(builder, room, {});
  if (chance(random, 0.5)) {
    Material polish = builder.scene.materials[static_cast<size_t>(builder.scene.objects[0].material)];
    if (polish.kind == MaterialKind::diffuse) {
      polish.kind = MaterialKind::plastic;
      polish.roughness = random.uniform(0, 0.15F);
      builder.scene.objects[0].material = builder.add(polish);  // the floor
    }
  }
  Material glass;
  glass.kind = MaterialKind::mirror;
  glass.colour = plain_texture(grey(0.93F));
  glass.roughness = 0;
  const Wall& back = room.walls[kBack];
  const float width = random.uniform(0.4F, 0.65F) * back.width,
              height = random.uniform(0.5F, 0.75F) * back.height,
              s = random.uniform(0.1F, 0.9F) * (back.width - width), t = 0.15F * back.height;
  builder.add(make_parallelogram(back.at(s, t, 0.02F), back.along * width, back.up * height), glass);
  for (const float side : {-0.5F, 0.5F}) {
    const float z = random.uniform(-0.4F, 0.4F), power = random.uniform(1, 2.5F);
    add_ceiling_lamp(builder, room.height, side * room.half.x, z * room.half.z, random.uniform(0.3F, 0.9F),
                     power);
  }
  const float x = random.uniform(-0.4F, 0.4F), y = random.uniform(1.1F, 1.7F),
              fov = random.uniform(0.8F, 1.05F);
  const Vec3 target = back.at(s + 0.5F * width, t + 0.5F * height);
  look(builder, {x * room.half.x, y, 0.8F * room.half.z}, target, fov);
  add_random_models(builder, std::max(5, count_of(draft.config, random)), 0.4, 1);
  for (size_t i = 0; i < builder.placed.size(); i += 2) {
    Motion motion;
    const float heading = random.uniform(0, 2 * kPi), pace = random.uniform(0.02F, 0.06F);
    if (i % 4 == 0) motion.translation = Vec3{std::cos(heading), 0, std::sin(heading)} * pace;
    motion.angle = random.uniform(-0.12F, 0.12F);
    motion.pivot = builder.placed[i].bounds.centre();
    set_motion(builder.scene, builder.placed[i], motion);
  }
  builder.scene.name = "stage";
  return std::move(builder.scene);
}

Scene thin_stage(const StageDraft& draft) {
  SceneBuilder builder = begin(draft);
  RandomStream& random = builder.random;
  const Room room = room_of(random);
  add_sides(builder, room, {});
  for (const float side : {-0.5F, 0.5F}) {
    const float z = random.uniform(-0.3F, 0.5F), power = random.uniform(1, 2.5F);
    add_ceiling_lamp(builder, room.height, side * room.half.x, z * room.half.z, random.uniform(0.2F, 0.7F),
                     power);
  }
  std::vector<const ModelKind*> thin;
  for (const ModelKind& kind : model_kinds())
    if (kind.family == Family::wire || kind.family == Family::plant) thin.push_back(&kind);
  constexpr int kInARow = 5;
  for (int i = 0; i < kInARow; ++i) {
    const ModelKind& kind = *thin[random.below(static_cast<uint32_t>(thin.size()))];
    const float x = 1.6F * (static_cast<float>(i) - 0.5F * (kInARow - 1)) / kInARow * room.half.x,
                z = random.uniform(-0.3F, 0.3F), turn = random.uniform(-0.5F, 0.5F);
    const float radius = random.uniform(0.5F, 0.9F);
    builder.stand(kind.make(random), {x, 0, z * room.half.z}, radius, turn);
  }
  const float x = random.uniform(-0.3F, 0.3F), fov = random.uniform(0.75F, 1);
  look(builder, {x * room.half.x, random.uniform(0.9F, 1.4F), 0.9F * room.half.z}, {0, 0.8F, 0}, fov);
  add_random_models(builder, kInARow + count_of(draft.config, random), 0.3, 1);
  builder.scene.name = "stage";
  return std::move(builder.scene);
}

}  // namespace ld
