#include "render/random/outdoors.h"

#include "render/geometry/noise.h"
#include "render/random/model_materials.h"
#include "render/random/random_materials.h"
#include "render/random/room_parts.h"
#include "render/random/shapes/furniture.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

/// The plain out to the horizon, `depth` below what lies nearer.
void add_plain(SceneBuilder& builder, int material, float depth) {
  builder.add(placed(make_ground(2000, 1, 0, 1, 0), grey(1), {}, {0, -depth, 0}), material);
}

/// A camera on the ground at some distance that looks at the middle; `spread` is the half angle around +z
/// that it keeps to.
void place_outdoor_camera(SceneBuilder& builder, float reach, float spread) {
  RandomStream& random = builder.random;
  Camera& camera = builder.scene.camera;
  constexpr int kTries = 60;  // then the last one has to do; the draft will be looked at
  for (int t = 0; t < kTries; ++t) {
    const float distance = reach * random.uniform(0.9F, 1.7F),
                angle = 0.5F * kPi + random.uniform(-spread, spread);
    camera.position = {distance * std::cos(angle), 0, distance * std::sin(angle)};
    camera.position.y = builder.floor(camera.position.x, camera.position.z) + log_uniform(random, 0.5F, 3.5F);
    const float tx = random.uniform(-0.3F, 0.3F), ty = random.uniform(0, 1.2F),
                tz = random.uniform(-0.3F, 0.3F);
    camera.axes = look_at(camera.position, {tx * reach, ty + builder.floor(0, 0), tz * reach}, {0, 1, 0},
                          random.uniform(-0.06F, 0.06F));
    if (builder.occupancy.distance(camera.position) > 0.5F) break;
  }
  camera.fov = random.uniform(0.5F, 1.05F);
}

void set_ground_spot(SceneBuilder& builder, float reach, float smallest, float largest) {
  builder.spots = {{{-reach, 0, -reach}, {reach, 0, reach}, smallest, largest}};
  builder.ceiling = 3.5F;
}

void build_hills(SceneBuilder& builder) {
  RandomStream& random = builder.random;
  add_environment(builder, false);
  const float amplitude = log_uniform(random, 0.15F, 1.4F), frequency = random.uniform(0.1F, 0.3F);
  const uint32_t hills = random.bits();
  builder.floor = [=](float x, float z) {
    return amplitude * fractal_noise(Vec3{x, 0, z} * frequency + grey(0.5F), 4, hills);
  };
  const int ground = add_wall_material(builder, WallKind::ground, kZ, kX);
  builder.add(make_ground(40, 120, amplitude, frequency, hills), ground);
  add_plain(builder, ground, 0.4F * amplitude + 0.05F);
  const float reach = random.uniform(3.5F, 7);
  set_ground_spot(builder, reach, 0.2F, 1.3F);
  place_outdoor_camera(builder, reach, kPi);
}

void build_plain(SceneBuilder& builder) {
  RandomStream& random = builder.random;
  add_environment(builder, false);
  add_plain(builder, add_wall_material(builder, WallKind::ground, kZ, kX), 0);
  const int stones = static_cast<int>(random.below(9));  // boulders or trees further off
  for (int i = 0; i < stones; ++i) {
    const float angle = random.uniform(0, 2 * kPi), distance = random.uniform(14, 40),
                size = random.uniform(1.5F, 5);
    Model model = {{make_rock(random), Stuff::stone, true}};
    if (chance(random, 0.6)) {
      Plant tree = make_tree(random);
      model = {{std::move(tree.stems), Stuff::wood, true}};
      if (!tree.leaves.positions.empty()) model.push_back({std::move(tree.leaves), Stuff::leaf, false});
    }
    fit_to_unit(model);
    builder.stand(std::move(model), {distance * std::cos(angle), 0, distance * std::sin(angle)}, size, angle);
  }
  const float reach = random.uniform(3.5F, 7);
  set_ground_spot(builder, reach, 0.2F, 1.3F);
  place_outdoor_camera(builder, reach, kPi);
}

/// A studio: the floor bends up into a wall, lit by large lamps.
void build_cyclorama(SceneBuilder& builder) {
  RandomStream& random = builder.random;
  add_environment(builder, true);
  scale_environment(builder.scene, log_uniform(random, 0.05F, 1));
  const float back = random.uniform(3.5F, 6), bend = random.uniform(1, 3.5F), width = 24, height = 12,
              front = 16;
  constexpr int kSteps = 24;
  Mesh sweep = make_surface(1, kSteps + 2, 0.4F, [&](int i, int j) {
    const float x = width * (2 * static_cast<float>(i) - 1),
                angle = 0.5F * kPi * share(std::clamp(j - 1, 0, kSteps), kSteps);
    Vec3 p = {x, bend * (1 - std::cos(angle)), -back - bend * std::sin(angle)};
    if (j == 0) p = {x, 0, front};
    if (j == kSteps + 2) p.y = height;
    return p;
  });
  sweep.uvs.clear();
  builder.add(std::move(sweep),
              add_wall_material(builder, chance(random, 0.6) ? WallKind::ceiling : WallKind::wall, kX, kY));
  const uint32_t lights = 1 + random.below(4);
  for (uint32_t i = 0; i < lights; ++i) {
    const float angle = random.uniform(0, kPi), distance = random.uniform(4, 7), y = random.uniform(3, 6.5F);
    const Vec3 at = {distance * std::cos(angle), y, distance * std::sin(angle)};
    const float w = log_uniform(random, 0.5F, 3), d = log_uniform(random, 0.5F, 3),
                power = random.uniform(4, 14);
    add_area_light(builder, at, normalize(Vec3{0, 0.5F, -1} - at), w, d, power, true);
  }
  if (chance(random, 0.4)) {
    const float x = random.uniform(-3, 3);
    add_point_light(builder, {x, 4, 3}, normalize(Vec3{-x, -4, -3}), random.uniform(1, 5));
  }
  const float reach = back * random.uniform(0.7F, 0.95F);
  set_ground_spot(builder, reach, 0.15F, 1);
  place_outdoor_camera(builder, reach, 0.9F);
}

/// A house front facing `direction` in the distance, with dark shiny windows.
void add_house(SceneBuilder& builder, Vec3 foot, Vec3 along, float width, float height, float depth) {
  RandomStream& random = builder.random;
  const Wall front = {foot, along, kY, width, height};
  const int columns = 2 + static_cast<int>(width / 3.2F), floors = 1 + static_cast<int>(height / 3.4F);
  std::vector<Opening> windows;
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < floors; ++j) {
      const float s = width / static_cast<float>(columns), t = height / static_cast<float>(floors);
      const float x = s * static_cast<float>(i), y = t * static_cast<float>(j);
      windows.push_back({x + 0.28F * s, y + 0.3F * t, x + 0.72F * s, y + 0.8F * t});
    }
  const int plaster = add_wall_material(builder, WallKind::wall, along, kY);
  add_wall(builder, front, windows, plaster, 0.3F);
  Material pane;
  pane.kind = MaterialKind::plastic;
  pane.colour = plain_texture(random_colour(random) * 0.08F);
  pane.roughness = 0;
  builder.add(make_parallelogram(front.at(0, 0, -0.3F), along * width, kY * height), pane);
  const Vec3 in = front.normal() * -depth;
  builder.add(make_parallelogram(front.at(0, height), along * width, in), plaster);
  builder.add(make_parallelogram(front.at(0, 0), kY * height, in), plaster);
  builder.add(make_parallelogram(front.at(width, 0), in, kY * height), plaster);
}

/// A paved square between houses, with columns or lamps around.
void build_plaza(SceneBuilder& builder) {
  RandomStream& random = builder.random;
  add_environment(builder, false);
  add_plain(builder, add_wall_material(builder, WallKind::floor, kZ, kX), 0);
  const float square = random.uniform(10, 18);
  const uint32_t sides = 1 + random.below(3);
  for (uint32_t side = 0; side < 4; ++side) {
    if (side > sides) continue;
    const Basis turn = turned_about(kY, 0.5F * kPi * static_cast<float>(side));
    for (float s = -square; s < square - 3;) {
      const float width = random.uniform(4, 9), height = random.uniform(3.5F, 14),
                  back = random.uniform(0, 1.5F);
      if (chance(random, 0.85))
        add_house(builder, turn.to_world({s, 0, -square - back}), turn.to_world(kX), width, height, 6);
      s += width + (chance(random, 0.3) ? 1.5F : 0.0F);
    }
  }
  const int posts = 4 + static_cast<int>(random.below(9));
  const float ring = random.uniform(6.5F, 9);
  const RandomStream make = random;
  for (int i = 0; i < posts; ++i) {
    const float angle = 2 * kPi * (share(i, posts) + 0.03F);
    RandomStream same = make;  // all alike
    Model post = make_column(same);
    builder.furnish(std::move(post), {ring * std::cos(angle), 0, ring * std::sin(angle)}, -angle);
  }
  const float reach = random.uniform(3.5F, 6);
  set_ground_spot(builder, reach, 0.15F, 1.1F);
  place_outdoor_camera(builder, reach, kPi);
}

/// Wide steps that rise away from the camera, with walls to the sides.
void build_steps(SceneBuilder& builder) {
  RandomStream& random = builder.random;
  add_environment(builder, false);
  const float rise = random.uniform(0.12F, 0.3F), tread = random.uniform(0.7F, 1.4F),
              start = random.uniform(0.5F, 2.5F);
  const int count = 4 + static_cast<int>(random.below(8));
  const float width = random.uniform(5, 9);
  builder.floor = [=](float, float z) {
    const float step =
        std::floor((start - z + 0.35F) / tread) + 1;  // what stands near an edge stands on the upper step
    return rise * std::clamp(step, 0.0F, static_cast<float>(count));
  };
  const int ground = add_wall_material(builder, WallKind::ground, kZ, kX);
  add_plain(builder, ground, 0);
  const int stone = chance(random, 0.5) ? ground : add_wall_material(builder, WallKind::floor, kX, kZ);
  Mesh steps;
  for (int i = 0; i < count; ++i) {
    const float k = static_cast<float>(i), z = start - tread * k, back = i + 1 == count ? 12 : 0.5F * tread;
    append(steps, make_block({0, 0.5F * rise * (k + 1), z - back}, {width, 0.5F * rise * (k + 1), back}));
  }
  builder.add(std::move(steps), stone);
  const float top = rise * static_cast<float>(count);
  Mesh walls;
  const float tall = random.uniform(0.2F, 1.5F);
  for (const float side : {-1.0F, 1.0F})
    append(walls, make_block({side * (width + 0.3F), 0.5F * (top + tall), start - 7},
                             {0.3F, 0.5F * (top + tall), 7.5F}));
  builder.add(std::move(walls), add_wall_material(builder, WallKind::wall, kZ, kY));
  if (chance(random, 0.5)) {  // a colonnade above
    const int posts = 4 + static_cast<int>(random.below(5));
    const RandomStream make = random;
    const float z = start - tread * static_cast<float>(count) - 3;
    for (int i = 0; i < posts; ++i) {
      RandomStream same = make;
      Model post = make_column(same);
      place(post, grey(1.6F), {}, {});
      builder.furnish(std::move(post), {width * (2 * share(i, posts - 1) - 1) * 0.9F, top, z}, 0);
    }
  }
  const float reach = random.uniform(3.5F, 5);
  set_ground_spot(builder, reach, 0.12F, 0.8F);
  place_outdoor_camera(builder, reach, 0.8F);
}

/// Walls on two or three sides, one with an arcade of openings.
void build_courtyard(SceneBuilder& builder) {
  RandomStream& random = builder.random;
  add_environment(builder, false);
  add_plain(builder, add_wall_material(builder, WallKind::floor, kZ, kX), 0);
  const float half = random.uniform(5, 8), height = random.uniform(2, 6);
  const auto walls = box_walls({half, 0, half}, height);
  const int paint = add_wall_material(builder, WallKind::wall, kX, kY);
  const uint32_t sides = 2 + random.below(2);
  constexpr WallIndex kOrder[] = {kBack, kLeft, kRight};
  for (uint32_t i = 0; i < sides; ++i) {
    const Wall& wall = walls[kOrder[i]];
    std::vector<Opening> arches;
    if (chance(random, 0.6)) {
      const int bays = 3 + static_cast<int>(random.below(5));
      const float pitch = wall.width / static_cast<float>(bays),
                  sill = chance(random, 0.5) ? 0.01F : 0.3F * height;
      for (int k = 0; k < bays; ++k)
        arches.push_back({pitch * (static_cast<float>(k) + 0.2F), sill,
                          pitch * (static_cast<float>(k) + 0.8F), 0.8F * height});
    }
    add_wall(builder, wall, arches, paint, 0.5F);
  }
  const int beds = static_cast<int>(random.below(5));
  for (int i = 0; i < beds; ++i) {
    Plant tree = make_tree(random);
    Model model = {{std::move(tree.stems), Stuff::wood, true}};
    if (!tree.leaves.positions.empty()) model.push_back({std::move(tree.leaves), Stuff::leaf, false});
    fit_to_unit(model);
    const float x = random.uniform(-0.8F, 0.8F), size = random.uniform(1, 2.5F);
    builder.stand(std::move(model), {x * half, 0, -half + 1.5F}, size, x);
  }
  const float reach = half * random.uniform(0.6F, 0.85F);
  set_ground_spot(builder, reach, 0.15F, 1);
  place_outdoor_camera(builder, reach, 1.1F);
}

}  // namespace

const std::vector<BackdropKind>& backdrop_kinds() {
  static const std::vector<BackdropKind> kinds = {
      {"hills", build_hills}, {"plain", build_plain}, {"cyclorama", build_cyclorama},
      {"plaza", build_plaza}, {"steps", build_steps}, {"courtyard", build_courtyard}};
  return kinds;
}

}  // namespace ld
