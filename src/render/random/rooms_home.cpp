#include "render/random/model_materials.h"
#include "render/random/random_materials.h"
#include "render/random/room_parts.h"
#include "render/random/rooms.h"
#include "render/random/shapes/furniture.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

void add_floor_and_ceiling(SceneBuilder& builder, const std::array<Wall, 6>& walls) {
  add_wall(builder, walls[kFloor], {}, add_wall_material(builder, WallKind::floor, kZ, kX));
  add_wall(builder, walls[kCeiling], {}, add_wall_material(builder, WallKind::ceiling, kX, kZ));
}

/// Lamps at the ceiling, as many as `count`, together as bright as the room needs.
void add_ceiling_lights(SceneBuilder& builder, Vec3 half, float height, uint32_t count) {
  RandomStream& random = builder.random;
  const float power = 0.05F * half.x * half.z * 4 / static_cast<float>(count);
  for (uint32_t i = 0; i < count; ++i) {
    const float width = log_uniform(random, 0.2F, 1), depth = log_uniform(random, 0.2F, 1);
    const float x = random.uniform(-0.7F, 0.7F), z = random.uniform(-0.7F, 0.7F),
                drop = random.uniform(0.02F, 0.6F);
    const bool hangs = chance(random, 0.4);
    add_area_light(builder, {x * half.x, height - (hangs ? drop : 0.02F), z * half.z}, {0, -1, 0}, width,
                   depth, power * random.uniform(0.5F, 1.5F), hangs);
  }
}

void add_rug(SceneBuilder& builder, Vec3 middle) {
  RandomStream& random = builder.random;
  const float x = random.uniform(0.7F, 1.5F), z = random.uniform(0.5F, 1.2F);
  Mesh rug = chance(random, 0.3) ? placed(make_cylinder(0.006F, 1, 64), {x, 1, x}, {}, middle)
                                 : make_block(middle + Vec3{0, 0.006F, 0}, {x, 0.006F, z});
  const int material = add_material_of(builder, {make_block({}, {x, 0.01F, z}), Stuff::cloth, true});
  builder.add(std::move(rug), material);
}

}  // namespace

void build_living_room(SceneBuilder& builder, int count) {
  RandomStream& random = builder.random;
  const Vec3 half = {random.uniform(2.2F, 3.3F), 0, random.uniform(2, 2.9F)};
  const float height = random.uniform(2.4F, 3.1F);
  const auto walls = box_walls(half, height);
  add_floor_and_ceiling(builder, walls);
  const int paint = add_wall_material(builder, WallKind::wall, kX, kY);
  for (const WallIndex i : {kBack, kFront, kLeft, kRight}) {
    std::vector<Opening> holes;
    const bool windowed = i == kBack || (i == kLeft && chance(random, 0.5));
    if (windowed) {
      holes.push_back(random_window(builder, walls[i], random.uniform(0, 1)));
      dress_window(builder, walls[i], holes[0]);
    }
    add_wall(
        builder, walls[i], holes,
        i == kFront && chance(random, 0.4) ? add_wall_material(builder, WallKind::wall, -kX, kY) : paint);
  }
  add_door(builder, walls[kRight], random.uniform(0.7F, 2 * half.z - 0.7F));
  add_environment(builder, false);
  scale_environment(builder.scene, log_uniform(random, 0.03F, 0.4F));

  set_floor_spot(builder, half, height, 0.7F);
  add_rug(builder, {random.uniform(-0.5F, 0.5F), 0, random.uniform(-0.4F, 0.4F)});
  const float sofa_at = random.uniform(1, 2 * half.x - 1);
  set_against(builder, walls[kFront], sofa_at, make_sofa(random), 0.05F);
  const Vec3 middle = {random.uniform(-0.5F, 0.5F), 0, random.uniform(-0.2F, 0.3F)};
  const float askew = random.uniform(-0.2F, 0.2F);
  builder.furnish(make_table(random), middle, askew);
  make_spot(builder, 0.05F, 0.2F);
  const float shelf_at = random.uniform(0.6F, 2 * half.z - 0.6F);
  set_against(builder, walls[kLeft], shelf_at,
              chance(random, 0.6) ? make_bookshelf(random) : make_cabinet(random));
  make_spot(builder, 0.06F, 0.18F);
  builder.furnish(make_floor_lamp(random), {0.8F * half.x, 0, -0.75F * half.z}, 0);
  const uint32_t pictures = 1 + random.below(3);
  for (uint32_t i = 0; i < pictures && builder.count() < count; ++i) {
    const float at = random.uniform(0.7F, 2 * half.x - 0.7F), level = random.uniform(1.4F, 1.8F);
    hang(builder, walls[kFront], at, level, make_picture(random));
  }
  if (chance(random, 0.4)) {
    Model sofa = make_sofa(random);
    builder.furnish(std::move(sofa), {-0.6F * half.x, 0, 0.2F * half.z}, 0.5F * kPi);
  }
  add_ceiling_lights(builder, half, height, 1 + random.below(3));
  if (chance(random, 0.6)) {
    const float x = random.uniform(-0.6F, 0.6F);
    add_point_light(builder, {x * half.x, height - 0.4F, 0.3F * half.z}, {0, -1, 0}, 0.1F * half.x);
  }
  place_camera(builder,
               {{-0.9F * half.x, 0.5F, -0.9F * half.z}, {0.9F * half.x, 0.75F * height, 0.9F * half.z}}, 2,
               0.8F, 1.25F);
}

void build_kitchen(SceneBuilder& builder, int count) {
  RandomStream& random = builder.random;
  const Vec3 half = {random.uniform(1.9F, 2.8F), 0, random.uniform(1.9F, 2.7F)};
  const float height = random.uniform(2.4F, 2.9F), top = 0.9F;
  const auto walls = box_walls(half, height);
  add_floor_and_ceiling(builder, walls);
  const int paint = add_wall_material(builder, WallKind::wall, kX, kY);
  for (const WallIndex i : {kBack, kFront, kLeft, kRight}) {
    std::vector<Opening> holes;
    if (i == kBack || (i == kRight && chance(random, 0.4))) {
      holes.push_back(random_window(builder, walls[i], 1.1F));
      if (chance(random, 0.5)) dress_window(builder, walls[i], holes[0]);
    }
    add_wall(builder, walls[i], holes, paint);
  }
  add_door(builder, walls[kFront], random.uniform(0.7F, 2 * half.x - 0.7F));
  add_environment(builder, false);
  scale_environment(builder.scene, log_uniform(random, 0.03F, 0.4F));
  set_floor_spot(builder, half, height, 0.55F);

  const int fronts = add_material_of(
      builder, {make_block({}, grey(0.4F)), chance(random, 0.5) ? Stuff::wood : Stuff::ceramic, true});
  const int counter = add_material_of(
      builder, {make_block({}, grey(0.6F)), chance(random, 0.6) ? Stuff::stone : Stuff::metal, true});
  const int handles = add_material_of(builder, {make_sphere(1), Stuff::metal, true});
  const int splash = add_wall_material(builder, WallKind::floor, kX, kY);
  for (const WallIndex i : {kBack, kLeft}) {
    const Wall& wall = walls[i];
    const Basis axes = {wall.along, wall.up, wall.normal()};
    const float width = wall.width;
    const auto put = [&](Mesh mesh, float s, float t, float lift) {
      return placed(std::move(mesh), grey(1), axes, wall.at(s, t, lift));
    };
    builder.add(put(make_rounded_box({0.5F * width, 0.02F, 0.31F}, 0.01F), 0.5F * width, top, 0.31F),
                counter);
    const int doors = std::max(2, static_cast<int>(width / 0.55F));
    const float pitch = width / static_cast<float>(doors);
    Mesh boards, grips, upper;
    for (int k = 0; k < doors; ++k) {
      const float s = pitch * (static_cast<float>(k) + 0.5F);
      append(boards, put(make_rounded_box({0.48F * pitch, 0.38F, 0.28F}, 0.008F), s, 0.49F, 0.29F));
      append(grips, put(make_rod({-0.08F, 0, 0}, {0.08F, 0, 0}, 0.007F, 8), s, 0.8F, 0.6F));
      if (i == kLeft)
        append(upper, put(make_rounded_box({0.48F * pitch, 0.34F, 0.16F}, 0.008F), s, 1.9F, 0.17F));
    }
    if (i == kLeft) append(boards, std::move(upper));
    builder.add(std::move(boards), fronts);
    builder.add(std::move(grips), handles);
    if (i == kLeft)
      builder.add(make_parallelogram(wall.at(0, top, 0.008F), wall.along * width, kY * 0.62F), splash);
    const Vec3 a = wall.at(0, top + 0.02F, 0.02F), b = wall.at(width, top + 0.02F, 0.6F);
    const Vec3 low = {std::min(a.x, b.x), a.y, std::min(a.z, b.z)},
               high = {std::max(a.x, b.x), a.y, std::max(a.z, b.z)};
    make_spot(builder, low, high, 0.05F, 0.17F);
    builder.occupancy.take({{low.x, 0, low.z}, high});
    if (i == kLeft) builder.occupancy.take({{low.x, 1.5F, low.z}, {0.5F * (low.x + high.x), 2.3F, high.z}});
  }
  const float askew = random.uniform(-0.3F, 0.3F);
  builder.furnish(make_table(random), {0.25F * half.x, 0, 0.25F * half.z}, askew);
  make_spot(builder, 0.05F, 0.17F);
  const int seats = 1 + static_cast<int>(random.below(4));
  for (int i = 0; i < seats && builder.count() < count; ++i) {
    const float a = 2 * kPi * share(i, seats) + random.uniform(-0.3F, 0.3F);
    const Vec3 at = {0.25F * half.x + 0.85F * std::cos(a), 0, 0.25F * half.z + 0.75F * std::sin(a)};
    const Model seat = chance(random, 0.6) ? make_chair(random) : make_stool(random);
    builder.furnish(seat, at, std::atan2(-std::cos(a), -std::sin(a)));
  }
  if (chance(random, 0.7))
    add_area_light(builder, {0.25F * half.x, height - random.uniform(0.6F, 1), 0.25F * half.z}, {0, -1, 0},
                   0.3F, 0.3F, 0.5F, true);
  add_ceiling_lights(builder, half, height, 1 + random.below(3));
  if (chance(random, 0.5))
    add_point_light(builder, {-0.5F * half.x, 1.5F, -0.5F * half.z}, {0, -1, 0}, 0.15F);
  place_camera(builder,
               {{-0.6F * half.x, 0.9F, -0.6F * half.z}, {0.93F * half.x, 0.75F * height, 0.93F * half.z}},
               1.6F, 0.85F, 1.3F);
}

void build_attic(SceneBuilder& builder, int) {
  RandomStream& random = builder.random;
  const Vec3 half = {random.uniform(2, 3), 0, random.uniform(2.5F, 4)};
  const float knee = random.uniform(0.5F, 1.1F), ridge = knee + half.x * random.uniform(0.7F, 1.1F);
  const auto walls = box_walls(half, ridge);
  add_wall(builder, walls[kFloor], {}, add_wall_material(builder, WallKind::floor, kZ, kX));
  const int paint = add_wall_material(builder, WallKind::wall, kX, kY),
            lining = add_wall_material(builder, WallKind::ceiling, kZ, kX);
  const int timber = add_material_of(builder, {make_block({}, grey(0.3F)), Stuff::wood, true});
  for (const WallIndex i : {kBack, kFront}) {  // gable ends: the roof cuts off what stands over it
    std::vector<Opening> holes;
    if (i == kBack || chance(random, 0.4)) {
      const float w = random.uniform(0.3F, 0.7F);
      holes.push_back({half.x - w, 0.6F, half.x + w, std::min(ridge - 0.7F, 2.0F)});
      add_window_frame(builder, walls[i], holes[0], 2, 2);
    }
    add_wall(builder, walls[i], holes, paint);
  }
  const float rise = ridge - knee, slope = std::sqrt(half.x * half.x + rise * rise);
  for (const float side : {-1.0F, 1.0F}) {
    const Vec3 foot = {side * half.x, 0, side > 0 ? -half.z : half.z}, along = {0, 0, side};
    add_wall(builder, {foot, along, kY, 2 * half.z, knee}, {}, paint);
    const Vec3 up = Vec3{-side * half.x, rise, 0} / slope;
    const Wall roof = {foot + kY * knee, along, up, 2 * half.z, slope};
    std::vector<Opening> holes;
    const uint32_t lights = random.below(3);
    for (uint32_t k = 0; k < lights; ++k) {
      const float s = 2 * half.z * (static_cast<float>(k) + 0.3F) / static_cast<float>(lights),
                  t = random.uniform(0.25F, 0.4F) * slope;
      holes.push_back({s, t, s + random.uniform(0.5F, 0.9F), t + random.uniform(0.6F, 1)});
      add_window_frame(builder, roof, holes.back(), 1, 1);
    }
    add_wall(builder, roof, holes, lining);
    Mesh rafters;
    const Basis axes = {along, up, cross(along, up)};
    const int count = 4 + static_cast<int>(random.below(3));
    for (int k = 0; k < count; ++k) {
      const float s = 2 * half.z * (static_cast<float>(k) + 0.02F) / static_cast<float>(count - 1) * 0.96F;
      append(rafters, placed(make_block({}, {0.05F, 0.5F * slope, 0.06F}), grey(1), axes,
                             roof.at(s + 0.05F, 0.5F * slope, 0.05F)));
    }
    builder.add(std::move(rafters), timber);
  }
  Mesh collars;
  const float collar = knee + 0.65F * rise, reach = half.x * 0.35F;
  for (int k = 0; k < 4; ++k)
    append(collars, make_block({0, collar, half.z * (2 * share(k, 3) - 1) * 0.9F}, {reach, 0.06F, 0.04F}));
  append(collars, make_block({0, ridge - 0.08F, 0}, {0.06F, 0.08F, half.z}));
  builder.add(std::move(collars), timber);
  add_environment(builder, false);
  scale_environment(builder.scene, log_uniform(random, 0.03F, 0.4F));

  builder.spots = {{{-0.8F * half.x, 0, -half.z}, {0.8F * half.x, 0, half.z}, 0.18F, 0.6F}};
  builder.ceiling = 0.6F * ridge;
  for (const WallIndex i : {kLeft, kRight}) {
    const float s = random.uniform(0.8F, 2 * half.z - 0.8F);
    const Model model = chance(random, 0.5) ? make_box_stack(random) : make_radiator(random);
    set_against(builder, walls[i], s, model, 0.1F);
  }
  const Model rest = chance(random, 0.5) ? make_bed(random) : make_sofa(random);
  const float aside = random.uniform(-0.3F, 0.3F), askew = random.uniform(-0.5F, 0.5F);
  builder.furnish(rest, {aside * half.x, 0, -0.45F * half.z}, askew);
  for (int i = 0; i < 2; ++i) {
    const float width = log_uniform(random, 0.15F, 0.4F);
    const float z = random.uniform(-0.7F, 0.7F);
    add_area_light(builder, {0, collar - 0.15F, z * half.z}, {0, -1, 0}, width, width, 0.25F * half.x, true);
  }
  if (chance(random, 0.6))
    add_point_light(builder, {0.3F * half.x, 0.8F * collar, 0.4F * half.z}, {0, -1, 0}, 0.2F);
  place_camera(builder,
               {{-0.55F * half.x, 0.6F, -0.93F * half.z},
                {0.55F * half.x, std::max(1.2F, 0.55F * ridge), 0.93F * half.z}},
               2, 0.8F, 1.3F);
}

void build_loft(SceneBuilder& builder, int count) {
  RandomStream& random = builder.random;
  const Vec3 half = {random.uniform(3.5F, 5.5F), 0, random.uniform(3, 4.5F)};
  const float height = random.uniform(4, 5.5F);
  const auto walls = box_walls(half, height);
  add_floor_and_ceiling(builder, walls);
  const int paint = add_wall_material(builder, WallKind::wall, kX, kY);
  const bool corner = chance(random, 0.5);  // glass on two sides
  for (const WallIndex i : {kBack, kFront, kLeft, kRight}) {
    std::vector<Opening> holes;
    if (i == kBack || (corner && i == kRight)) {
      holes.push_back({0.15F, random.uniform(0, 0.4F), walls[i].width - 0.15F, height - 0.3F});
      const int columns = 3 + static_cast<int>(random.below(6)), rows = 2 + static_cast<int>(random.below(4));
      add_window_frame(builder, walls[i], holes[0], columns, rows);
    }
    add_wall(builder, walls[i], holes,
             i == kLeft && chance(random, 0.5) ? add_wall_material(builder, WallKind::wall, -kZ, kY) : paint);
  }
  add_environment(builder, false);
  scale_environment(builder.scene, log_uniform(random, 0.03F, 0.4F));
  set_floor_spot(builder, half, height, 0.9F);

  // A gallery across the room's far end, with a rail, on posts.
  const float depth = random.uniform(1.3F, 2.2F), level = random.uniform(2.2F, 2.6F);
  const Vec3 middle = {0, level, half.z - 0.5F * depth};
  const int slab = add_wall_material(builder, WallKind::floor, kZ, kX);
  builder.add(make_block(middle, {half.x, 0.08F, 0.5F * depth}), slab);
  builder.occupancy.take(
      {middle - Vec3{half.x, 0.08F, 0.5F * depth}, middle + Vec3{half.x, 0.08F, 0.5F * depth}});
  make_spot(builder, {-half.x, level + 0.08F, half.z - depth}, {half.x, level + 0.08F, half.z}, 0.15F, 0.5F);
  Mesh rail, posts;
  const float edge = half.z - depth + 0.05F;
  const int bars = 24;
  for (int i = 0; i <= bars; ++i) {
    const float x = half.x * (2 * share(i, bars) - 1) * 0.98F;
    append(rail, make_rod({x, level, edge}, {x, level + 0.9F, edge}, 0.01F, 6));
  }
  append(rail, make_rod({-half.x, level + 0.9F, edge}, {half.x, level + 0.9F, edge}, 0.025F, 8));
  for (const float x : {-0.5F, 0.5F})
    append(posts, make_rod({x * half.x, 0, edge}, {x * half.x, level, edge}, 0.07F, 14));
  const int steel = add_material_of(builder, {make_sphere(1), Stuff::metal, true});
  builder.add(std::move(rail), steel);
  builder.add(std::move(posts), steel);
  const float askew = random.uniform(0, 0.4F);
  builder.furnish(chance(random, 0.5) ? make_spiral_stairs(random) : make_stairs(random),
                  {0.7F * half.x, 0, edge - 1.6F}, askew);

  add_rug(builder, {-0.2F * half.x, 0, -0.2F * half.z});
  const float sofa_at = random.uniform(1.2F, 2 * half.z - 1.2F);
  set_against(builder, walls[kLeft], sofa_at, make_sofa(random), 0.05F);
  for (int i = 0; i < 3 && builder.count() < count; ++i) {
    const float x = random.uniform(-0.6F, 0.4F), z = random.uniform(-0.6F, 0.2F),
                turn = random.uniform(0, 2 * kPi);
    builder.furnish(i == 0 ? make_table(random) : make_chair(random), {x * half.x, 0, z * half.z}, turn);
    if (i == 0) make_spot(builder, 0.06F, 0.25F);
  }
  add_ceiling_lights(builder, half, height, 2 + random.below(3));
  if (chance(random, 0.5)) add_point_light(builder, {0, level - 0.3F, half.z - 0.6F}, {0, -1, 0}, 0.3F);
  place_camera(builder,
               {{-0.9F * half.x, 0.7F, -0.9F * half.z}, {0.9F * half.x, 0.7F * height, 0.9F * half.z}}, 3,
               0.8F, 1.2F);
}

}  // namespace ld
