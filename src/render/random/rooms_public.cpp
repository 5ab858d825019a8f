#include "render/random/model_materials.h"
#include "render/random/random_materials.h"
#include "render/random/room_parts.h"
#include "render/random/rooms.h"
#include "render/random/shapes/furniture.h"
#include "render/random/shapes/shapes.h"

namespace ld {
void build_office(SceneBuilder& builder, int count) {
  RandomStream& random = builder.random;
  const Vec3 half = {random.uniform(2.8F, 4.5F), 0, random.uniform(2.5F, 3.8F)};
  const float height = random.uniform(2.5F, 3);
  const auto walls = box_walls(half, height);
  add_wall(builder, walls[kFloor], {}, add_wall_material(builder, WallKind::floor, kZ, kX));
  add_wall(builder, walls[kCeiling], {}, add_wall_material(builder, WallKind::ceiling, kX, kZ));
  const int paint = add_wall_material(builder, WallKind::wall, kX, kY);
  // A ribbon of windows in the back wall.
  const int bays = 2 + static_cast<int>(random.below(3));
  std::vector<Opening> ribbon;
  for (int i = 0; i < bays; ++i) {
    const float pitch = 2 * half.x / static_cast<float>(bays), s = pitch * static_cast<float>(i);
    ribbon.push_back({s + 0.12F, 0.9F, s + pitch - 0.12F, height - 0.35F});
    add_window_frame(builder, walls[kBack], ribbon.back(), 1, 1);
    if (chance(random, 0.6)) dress_window(builder, walls[kBack], ribbon.back());
  }
  add_wall(builder, walls[kBack], ribbon, paint);
  for (const WallIndex i : {kFront, kLeft, kRight}) add_wall(builder, walls[i], {}, paint);
  add_door(builder, walls[kFront], random.uniform(0.7F, 2 * half.x - 0.7F));
  add_environment(builder, false);
  scale_environment(builder.scene, log_uniform(random, 0.03F, 0.4F));
  set_floor_spot(builder, half, height, 0.65F);

  // Rows of desks, all of one make.
  const RandomStream make = random;
  const int rows = 1 + static_cast<int>(random.below(2)), columns = 2 + static_cast<int>(random.below(2));
  const uint32_t style = random.below(2);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns && builder.count() + 3 < count; ++c) {
      const float x = half.x * (2 * (static_cast<float>(c) + 0.5F) / static_cast<float>(columns) - 1) * 0.85F;
      const float z = half.z * (rows == 1 ? -0.1F : (r == 0 ? -0.5F : 0.35F));
      RandomStream same = make;
      const float turn = style == 0 ? 0 : kPi;
      builder.furnish(make_table(same), {x, 0, z}, turn);
      make_spot(builder, 0.04F, 0.15F);
      const float top = builder.placed.back().bounds.high.y;
      const float screen_turn = turn + random.uniform(-0.3F, 0.3F),
                  chair_turn = turn + kPi + random.uniform(-0.6F, 0.6F), lamp_turn = random.uniform(0, 6);
      builder.furnish(make_monitor(random), {x, top, z - (turn == 0 ? 0.1F : -0.1F)}, screen_turn);
      if (chance(random, 0.8))
        builder.furnish(make_chair(random), {x, 0, z + (turn == 0 ? 0.75F : -0.75F)}, chair_turn);
      if (chance(random, 0.4)) builder.furnish(make_desk_lamp(random), {x + 0.3F, top, z}, lamp_turn);
    }
  const float cabinet_at = random.uniform(0.8F, 2 * half.z - 0.8F),
              shelf_at = random.uniform(0.8F, 2 * half.z - 0.8F);
  set_against(builder, walls[kLeft], cabinet_at, make_cabinet(random));
  make_spot(builder, 0.06F, 0.18F);
  set_against(builder, walls[kRight], shelf_at, make_bookshelf(random));
  for (int i = 0; i < 4; ++i) {  // panels in the ceiling; some are out
    const float x = i % 2 == 0 ? -0.5F : 0.5F, z = i < 2 ? -0.5F : 0.5F;
    if (chance(random, 0.2)) continue;
    add_area_light(builder, {x * half.x, height - 0.02F, z * half.z}, {0, -1, 0}, 0.6F,
                   chance(random, 0.5) ? 1.2F : 0.6F, 0.045F * half.x * half.z, false);
  }
  if (chance(random, 0.4)) add_point_light(builder, {0.6F * half.x, 1.6F, 0.5F * half.z}, {0, -1, 0}, 0.15F);
  place_camera(builder,
               {{-0.93F * half.x, 0.8F, -0.9F * half.z}, {0.93F * half.x, 0.8F * height, 0.93F * half.z}},
               2.2F, 0.8F, 1.2F);
}

void build_gallery(SceneBuilder& builder, int count) {
  RandomStream& random = builder.random;
  const Vec3 half = {random.uniform(3, 5), 0, random.uniform(3, 5)};
  const float height = random.uniform(3.2F, 4.6F);
  const auto walls = box_walls(half, height);
  add_wall(builder, walls[kFloor], {}, add_wall_material(builder, WallKind::floor, kZ, kX));
  std::vector<Opening> skylights;
  const int panes = 1 + static_cast<int>(random.below(3));
  const float reach = random.uniform(0.25F, 0.5F), pitch = 2 * half.x / static_cast<float>(panes);
  for (int i = 0; i < panes; ++i) {
    const float s = pitch * (static_cast<float>(i) + 0.2F);
    skylights.push_back({s, half.z * (1 - reach), s + 0.6F * pitch, half.z * (1 + reach)});
    add_window_frame(builder, walls[kCeiling], skylights.back(), 2 + static_cast<int>(random.below(3)), 2);
  }
  add_wall(builder, walls[kCeiling], skylights, add_wall_material(builder, WallKind::ceiling, kX, kZ), 0.5F);
  const int paint = add_wall_material(builder, WallKind::wall, kX, kY);
  for (const WallIndex i : {kBack, kFront, kLeft, kRight})
    add_wall(builder, walls[i], {},
             chance(random, 0.25) ? add_wall_material(builder, WallKind::wall, walls[i].along, kY) : paint);
  add_environment(builder, false);
  scale_environment(builder.scene, log_uniform(random, 0.03F, 0.4F));
  set_floor_spot(builder, half, height, 0.8F);

  for (const WallIndex i : {kBack, kFront, kLeft, kRight}) {  // pictures, larger than at home
    const int pictures = 1 + static_cast<int>(random.below(3));
    for (int k = 0; k < pictures && builder.count() < count; ++k) {
      Model picture = make_picture(random);
      place(picture, grey(random.uniform(1, 2)), {}, {});
      hang(builder, walls[i], walls[i].width * (static_cast<float>(k) + 0.5F) / static_cast<float>(pictures),
           random.uniform(1.5F, 1.8F), std::move(picture));
    }
  }
  const int plinths = 3 + static_cast<int>(random.below(6));
  const int plinth = add_material_of(
      builder, {make_block({}, grey(0.4F)), chance(random, 0.5) ? Stuff::stone : Stuff::ceramic, true});
  for (int i = 0; i < plinths; ++i) {
    const float side = random.uniform(0.2F, 0.4F), tall = random.uniform(0.5F, 1.2F);
    const Vec3 at = {random.uniform(-0.7F, 0.7F) * half.x, 0, random.uniform(-0.7F, 0.7F) * half.z};
    const Bounds box = {at - Vec3{side, 0, side}, at + Vec3{side, tall, side}};
    if (!builder.occupancy.is_free(box)) continue;
    builder.occupancy.take(box);
    builder.add(chance(random, 0.7) ? make_block(at + Vec3{0, 0.5F * tall, 0}, {side, 0.5F * tall, side})
                                    : placed(make_cylinder(0.5F, 1, 40), {side, tall, side}, {},
                                             at + Vec3{0, 0.5F * tall, 0}),
                plinth);
    const float s = 0.3F * side;
    builder.spots.push_back({at + Vec3{-s, tall, -s}, at + Vec3{s, tall, s}, 0.2F, 0.45F});
  }
  const uint32_t lights = 2 + random.below(3);
  for (uint32_t i = 0; i < lights; ++i) {
    const float x = random.uniform(-0.7F, 0.7F), z = chance(random, 0.5) ? -0.8F : 0.8F;
    const Vec3 direction = normalize(Vec3{random.uniform(-0.4F, 0.4F), -1, -0.4F * z});
    add_area_light(builder, {x * half.x, height - 0.3F, z * half.z}, direction, random.uniform(0.15F, 0.9F),
                   0.2F, 0.06F * half.x * half.z, true);
  }
  if (chance(random, 0.7)) add_point_light(builder, {0, height - 0.4F, 0}, {0, -1, 0}, 0.4F);
  place_camera(builder,
               {{-0.93F * half.x, 0.8F, -0.93F * half.z}, {0.93F * half.x, 0.6F * height, 0.93F * half.z}}, 3,
               0.75F, 1.2F);
}

void build_corridor(SceneBuilder& builder, int count) {
  RandomStream& random = builder.random;
  const Vec3 half = {random.uniform(1, 1.7F), 0, random.uniform(4, 7)};
  const float height = random.uniform(2.4F, 3.2F);
  const auto walls = box_walls(half, height);
  add_wall(builder, walls[kFloor], {}, add_wall_material(builder, WallKind::floor, kZ, kX));
  add_wall(builder, walls[kCeiling], {}, add_wall_material(builder, WallKind::ceiling, kX, kZ));
  const int paint = add_wall_material(builder, WallKind::wall, kZ, kY);
  // Light falls in at the far end, or from windows along one side.
  const Opening end = {0.3F, chance(random, 0.5) ? 0.02F : 0.9F, 2 * half.x - 0.3F, height - 0.4F};
  add_wall(builder, walls[kBack], {end}, add_wall_material(builder, WallKind::wall, kX, kY));
  add_window_frame(builder, walls[kBack], end, 2, 3);
  add_wall(builder, walls[kFront], {}, paint);
  const bool windows = chance(random, 0.5);
  std::vector<Opening> side;
  const int bays = 3 + static_cast<int>(random.below(3));
  const float pitch = 2 * half.z / static_cast<float>(bays);
  for (int i = 0; i < bays; ++i) {
    const float s = pitch * (static_cast<float>(i) + 0.5F);
    if (windows) {
      side.push_back({s - 0.3F * pitch, 0.8F, s + 0.3F * pitch, height - 0.4F});
      add_window_frame(builder, walls[kRight], side.back(), 2, 2);
    } else if (chance(random, 0.7)) {
      add_door(builder, walls[kRight], s);
    }
    if (chance(random, 0.6))
      add_door(builder, walls[kLeft], s);
    else if (chance(random, 0.6) && builder.count() < count)
      hang(builder, walls[kLeft], s, 1.55F, make_picture(random));
  }
  add_wall(builder, walls[kRight], side, paint);
  add_wall(builder, walls[kLeft], {}, paint);
  add_environment(builder, false);
  scale_environment(builder.scene, log_uniform(random, 0.03F, 0.4F));
  set_floor_spot(builder, half, height, 0.45F);

  Mesh pipes, arches;
  const int runs = static_cast<int>(random.below(5));
  for (int i = 0; i < runs; ++i) {
    const float x = (half.x - 0.1F - 0.14F * static_cast<float>(i)),
                y = height - 0.12F - random.uniform(0, 0.1F);
    append(pipes, make_rod({x, y, -half.z}, {x, y, half.z}, random.uniform(0.02F, 0.06F), 12));
  }
  if (runs > 0) builder.add(std::move(pipes), add_material_of(builder, {make_sphere(1), Stuff::metal, true}));
  if (chance(random, 0.5)) {  // pilasters
    for (int i = 0; i <= bays; ++i)
      for (const float x : {-1.0F, 1.0F})
        append(arches, make_block({x * half.x, 0.5F * height, pitch * static_cast<float>(i) - half.z},
                                  {0.12F, 0.5F * height, 0.12F}));
    builder.add(std::move(arches),
                add_material_of(builder, {make_block({}, grey(0.4F)), Stuff::stone, true}));
  }
  const float at = random.uniform(1, 2 * half.z - 1);
  set_against(builder, walls[kLeft], at, chance(random, 0.5) ? make_radiator(random) : make_cabinet(random));
  make_spot(builder, 0.06F, 0.18F);
  const uint32_t lights = 2 + random.below(3);
  for (uint32_t i = 0; i < lights; ++i) {
    const float z = half.z * (2 * (static_cast<float>(i) + 0.5F) / static_cast<float>(lights) - 1);
    const float width = random.uniform(0.2F, 0.4F), depth = random.uniform(0.2F, 1.2F);
    add_area_light(builder, {0, height - 0.03F, z}, {0, -1, 0}, width, depth, 0.3F * half.x, false);
  }
  if (chance(random, 0.4))
    add_point_light(builder, {0, 1.8F, random.uniform(-0.5F, 0.5F) * half.z}, {0, -1, 0}, 0.25F);
  place_camera(builder,
               {{-0.7F * half.x, 0.8F, -0.2F * half.z}, {0.7F * half.x, 0.75F * height, 0.97F * half.z}},
               2.2F, 0.75F, 1.2F);
}

void build_warehouse(SceneBuilder& builder, int count) {
  RandomStream& random = builder.random;
  const Vec3 half = {random.uniform(5, 8), 0, random.uniform(5, 8)};
  const float height = random.uniform(4.5F, 6.5F);
  const auto walls = box_walls(half, height);
  add_wall(builder, walls[kFloor], {}, add_wall_material(builder, WallKind::ground, kZ, kX));
  add_wall(builder, walls[kCeiling], {}, add_wall_material(builder, WallKind::ceiling, kX, kZ));
  const int paint = add_wall_material(builder, WallKind::wall, kX, kY);
  for (const WallIndex i : {kBack, kFront, kLeft, kRight}) {
    std::vector<Opening> holes;
    if (i == kBack || i == kRight || chance(random, 0.3)) {
      const int bays = 3 + static_cast<int>(random.below(4));
      const float pitch = walls[i].width / static_cast<float>(bays),
                  sill = random.uniform(0.3F, 0.6F) * height;
      for (int k = 0; k < bays; ++k) {
        holes.push_back({pitch * (static_cast<float>(k) + 0.15F), sill,
                         pitch * (static_cast<float>(k) + 0.85F), height - 0.5F});
        add_window_frame(builder, walls[i], holes.back(), 3, 3);
      }
    }
    add_wall(builder, walls[i], holes, paint);
  }
  add_environment(builder, false);
  scale_environment(builder.scene, log_uniform(random, 0.03F, 0.4F));
  builder.spots = {{{-0.8F * half.x, 0, -0.8F * half.z}, {0.8F * half.x, 0, 0.8F * half.z}, 0.25F, 1.2F}};
  builder.ceiling = 0.7F * height;

  Mesh columns, girders;
  const int rows = 2 + static_cast<int>(random.below(2));
  const bool round = chance(random, 0.5);
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < rows; ++k) {
      const Vec3 at = {half.x * (2 * share(i + 1, rows + 1) - 1), 0,
                       half.z * (2 * share(k + 1, rows + 1) - 1)};
      append(columns, round ? make_rod(at, at + kY * height, 0.2F, 24)
                            : make_block(at + kY * (0.5F * height), {0.17F, 0.5F * height, 0.17F}));
      builder.occupancy.take({at - Vec3{0.2F, 0, 0.2F}, at + Vec3{0.2F, height, 0.2F}});
    }
  builder.add(std::move(columns),
              add_material_of(builder, {make_block({}, grey(1)),
                                        chance(random, 0.5) ? Stuff::stone : Stuff::metal, true}));
  for (int i = 1; i <= rows; ++i) {  // trusses: two chords and the web between
    const float z = half.z * (2 * share(i, rows + 1) - 1), low = height - 0.7F, high = height - 0.1F;
    for (const float y : {low, high}) append(girders, make_block({0, y, z}, {half.x, 0.05F, 0.05F}));
    const int bays = 12;
    for (int k = 0; k < bays; ++k) {
      const float x0 = half.x * (2 * share(k, bays) - 1), x1 = half.x * (2 * share(k + 1, bays) - 1);
      append(girders,
             make_rod({x0, k % 2 == 0 ? low : high, z}, {x1, k % 2 == 0 ? high : low, z}, 0.025F, 6));
    }
  }
  builder.add(std::move(girders), add_material_of(builder, {make_block({}, grey(1)), Stuff::metal, true}));
  for (int i = 0; i < 6 && builder.count() < count; ++i) {
    const float s = random.uniform(0.8F, walls[kLeft].width - 0.8F);
    Model goods = i % 2 == 0 ? make_box_stack(random) : make_bookshelf(random);
    place(goods, grey(random.uniform(1.2F, 2)), {}, {});
    set_against(builder, i < 3 ? walls[kLeft] : walls[kFront], s, std::move(goods), 0.2F);
  }
  const uint32_t lights = 2 + random.below(3);
  for (uint32_t i = 0; i < lights; ++i) {
    const float x = random.uniform(-0.6F, 0.6F), z = random.uniform(-0.6F, 0.6F),
                width = log_uniform(random, 0.3F, 1.2F);
    add_area_light(builder, {x * half.x, height - 1, z * half.z}, {0, -1, 0}, width, width,
                   0.05F * half.x * half.z, true);
  }
  if (chance(random, 0.5)) add_point_light(builder, {0.4F * half.x, 2.5F, 0.4F * half.z}, {0, -1, 0}, 1);
  place_camera(builder,
               {{-0.85F * half.x, 0.8F, -0.85F * half.z}, {0.85F * half.x, 0.5F * height, 0.85F * half.z}}, 4,
               0.7F, 1.1F);
}

const std::vector<RoomKind>& room_kinds() {
  static const std::vector<RoomKind> kinds = {
      {"living room", build_living_room}, {"office", build_office}, {"gallery", build_gallery},
      {"corridor", build_corridor},       {"attic", build_attic},   {"warehouse", build_warehouse},
      {"kitchen", build_kitchen},         {"loft", build_loft}};
  return kinds;
}

}  // namespace ld
