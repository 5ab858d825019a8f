#include "render/random/shapes/furniture.h"

#include "render/geometry/mesh_tools.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

/// A leg from the floor up to `top`: square, round, tapered or turned on a lathe.
Mesh leg(uint32_t style, Vec3 top, float radius) {
  const float half = 0.5F * top.y;
  const Vec3 middle = {top.x, half, top.z};
  switch (style) {
    case 0:
      return make_block(middle, {radius, half, radius});
    case 1:
      return make_rod({top.x, 0, top.z}, top, radius, 12);
    case 2:
      return placed(make_prism({{1, 0}, {0, 1}, {-1, 0}, {0, -1}}, half, 0, 1.6F, 1), {radius, 1, radius}, {},
                    middle);
    default: {
      const std::vector<Vec2> turned = smooth_curve(
          std::vector<Vec2>{
              {0.6F, 0}, {1, 0.08F}, {0.5F, 0.2F}, {0.9F, 0.5F}, {0.5F, 0.8F}, {1.1F, 0.88F}, {1, 1}},
          5);
      std::vector<Vec2> profile = {{0, 0}};
      for (const Vec2 p : turned) profile.push_back({radius * p.x, top.y * p.y});
      profile.push_back({0, top.y});
      return moved(make_lathe(profile, 16), {top.x, 0, top.z});
    }
  }
}

Mesh cushion(Vec3 centre, Vec3 half) {
  const float least = std::min(half.x, std::min(half.y, half.z));
  return moved(make_rounded_box(half, 0.6F * least), centre);
}

void add_four_legs(Model& model, uint32_t style, float x, float z, float height, float radius) {
  for (const float sx : {-1.0F, 1.0F})
    for (const float sz : {-1.0F, 1.0F})
      add_part(model, Stuff::metal, leg(style, {sx * x, height, sz * z}, radius));
}

}  // namespace

Model make_table(RandomStream& random) {
  Model model;
  const float height = random.uniform(0.4F, 0.8F), thickness = random.uniform(0.02F, 0.06F);
  const float x = random.uniform(0.4F, 1.1F), z = random.uniform(0.35F, 0.6F);
  const bool round = random.below(3) == 0, glass = random.below(5) == 0;
  const Stuff top = glass ? Stuff::glass : Stuff::wood;
  const Vec3 centre = {0, height + thickness, 0};
  if (round) {
    add_part(model, top, placed(make_cylinder(thickness, 1, 48), {z, 1, z}, {}, centre));
    add_part(model, Stuff::metal, leg(random.below(4), {0, height, 0}, 0.05F));
    add_part(model, Stuff::metal,
             placed(make_cylinder(0.02F, 0.9F, 32), {0.5F * z, 1, 0.5F * z}, {}, {0, 0.02F, 0}));
  } else {
    add_part(model, top, moved(make_rounded_box({x, thickness, z}, 0.4F * thickness), centre));
    const uint32_t style = random.below(4);
    add_four_legs(model, style, x - 0.07F, z - 0.07F, height, random.uniform(0.02F, 0.05F));
  }
  return model;
}

Model make_chair(RandomStream& random) {
  Model model;
  const float half = random.uniform(0.19F, 0.25F), seat = random.uniform(0.42F, 0.5F),
              back = random.uniform(0.4F, 0.6F);
  const bool upholstered = random.below(2) == 0;
  const uint32_t style = random.below(4), slats = 2 + random.below(4);
  const float radius = random.uniform(0.014F, 0.025F);
  add_four_legs(model, style, half - 0.02F, half - 0.02F, seat, radius);
  if (upholstered)
    add_part(model, Stuff::cloth, cushion({0, seat + 0.04F, 0}, {half, 0.04F, half}));
  else
    add_part(model, Stuff::wood,
             moved(make_rounded_box({half, 0.015F, half}, 0.006F), {0, seat + 0.015F, 0}));
  const Basis lean = turned_about({1, 0, 0}, -random.uniform(0.05F, 0.25F));
  const Vec3 hinge = {0, seat + 0.02F, -half + 0.03F};
  for (const float side : {-1.0F, 1.0F})
    add_part(model, Stuff::metal,
             placed(make_rod({}, {0, back, 0}, radius, 10), grey(1), lean,
                    hinge + Vec3{side * (half - 0.02F), 0, 0}));
  if (upholstered) {
    add_part(model, Stuff::cloth,
             placed(cushion({0, 0.62F * back, 0}, {half, 0.36F * back, 0.035F}), grey(1), lean, hinge));
  } else {
    for (uint32_t i = 0; i < slats; ++i) {
      const float y = back * (0.3F + 0.65F * static_cast<float>(i) / static_cast<float>(slats));
      add_part(model, Stuff::wood,
               placed(make_block({0, y, 0}, {half, 0.03F, 0.009F}), grey(1), lean, hinge));
    }
  }
  return model;
}

Model make_stool(RandomStream& random) {
  Model model;
  const float height = random.uniform(0.35F, 0.8F), spread = random.uniform(0.12F, 0.22F);
  const int legs = 3 + static_cast<int>(random.below(3));
  const bool soft = random.below(2) == 0;
  for (int i = 0; i < legs; ++i) {
    const float a = 2 * kPi * share(i, legs);
    add_part(model, Stuff::metal,
             make_rod({1.4F * spread * std::cos(a), 0, 1.4F * spread * std::sin(a)},
                      {0.8F * spread * std::cos(a), height, 0.8F * spread * std::sin(a)}, 0.018F, 8));
  }
  std::vector<Vec3> ring;
  for (int i = 0; i < 24; ++i) {
    const float a = 2 * kPi * share(i, 24);
    ring.push_back({1.2F * spread * std::cos(a), 0.33F * height, 1.2F * spread * std::sin(a)});
  }
  add_part(model, Stuff::metal, make_tube(ring, 0.01F, 8, true));
  const Mesh seat = soft ? make_superellipsoid(0.4F, 1, 40) : make_cylinder(1, 1, 40);
  add_part(model, soft ? Stuff::cloth : Stuff::wood,
           placed(seat, {1.3F * spread, 0.03F, 1.3F * spread}, {}, {0, height + 0.02F, 0}));
  return model;
}

Model make_sofa(RandomStream& random) {
  Model model;
  const int seats = 1 + static_cast<int>(random.below(3));
  const float width = 0.32F, depth = 0.4F, x = width * static_cast<float>(seats),
              arm = random.uniform(0.07F, 0.14F);
  const float arm_height = random.uniform(0.5F, 0.7F), back = random.uniform(0.7F, 0.95F);
  add_part(model, Stuff::cloth, cushion({0, 0.2F, 0}, {x, 0.12F, depth}));
  for (const float side : {-1.0F, 1.0F})
    add_part(model, Stuff::cloth,
             cushion({side * (x + arm), 0.5F * arm_height + 0.03F, 0}, {arm, 0.5F * arm_height, depth}));
  add_part(model, Stuff::cloth, cushion({0, 0.5F * back + 0.05F, -depth}, {x + 2 * arm, 0.5F * back, 0.1F}));
  for (int i = 0; i < seats; ++i) {
    const float at = width * (2 * static_cast<float>(i) + 1) - x;
    add_part(model, Stuff::cloth, cushion({at, 0.38F, 0.05F}, {0.97F * width, 0.08F, depth - 0.03F}));
    const Basis lean = turned_about({1, 0, 0}, -0.25F);
    add_part(model, Stuff::cloth,
             placed(cushion({}, {0.9F * width, 0.2F, 0.07F}), grey(1), lean, {at, 0.62F, -0.24F}));
  }
  add_four_legs(model, 1, x, depth - 0.06F, 0.09F, 0.025F);
  return model;
}

Model make_bed(RandomStream& random) {
  Model model;
  const float x = random.uniform(0.45F, 0.95F), z = 1, board = random.uniform(0.6F, 1.1F);
  add_part(model, Stuff::wood, make_block({0, 0.2F, 0}, {x + 0.03F, 0.08F, z + 0.03F}));
  add_part(model, Stuff::wood,
           moved(make_rounded_box({x + 0.05F, 0.5F * board, 0.03F}, 0.02F), {0, 0.5F * board, -z - 0.05F}));
  add_four_legs(model, 0, x - 0.03F, z - 0.03F, 0.13F, 0.03F);
  add_part(model, Stuff::cloth, cushion({0, 0.38F, 0}, {x, 0.11F, z}));
  const int pillows = x > 0.7F ? 2 : 1;
  for (int i = 0; i < pillows; ++i) {
    const float at = pillows == 1 ? 0 : (i == 0 ? -0.5F * x : 0.5F * x);
    const Basis tilt = turned_about({1, 0, 0}, -0.4F);
    add_part(
        model, Stuff::paper,
        placed(make_superellipsoid(1.2F, 0.5F, 40), {0.36F, 0.1F, 0.22F}, tilt, {at, 0.56F, -0.75F * z}));
  }
  Mesh blanket = make_draped_sheet(random);
  const Bounds size = bounds_of(blanket.positions);
  // Its sides hang down to a hand above the floor.
  const float drop = 0.38F / std::max(0.1F, size.high.y - size.low.y);
  place(blanket, {1.12F * (x + 0.1F) / size.high.x, drop, 0.7F / size.high.z}, {}, {0, 0.51F, 0.38F});
  add_part(model, Stuff::any, std::move(blanket), false);
  return model;
}

Model make_cabinet(RandomStream& random) {
  Model model;
  const float x = random.uniform(0.3F, 0.8F), y = random.uniform(0.35F, 1), z = random.uniform(0.2F, 0.3F);
  const int columns = 1 + static_cast<int>(random.below(3)), rows = 1 + static_cast<int>(random.below(4));
  add_part(model, Stuff::wood, make_block({0, y + 0.06F, 0}, {x, y, z}));
  add_part(model, Stuff::metal, make_block({0, 0.03F, 0}, {0.95F * x, 0.03F, 0.95F * z}));
  const float w = x / static_cast<float>(columns), h = y / static_cast<float>(rows);
  const bool knobs = random.below(2) == 0;
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j) {
      const Vec3 c = {w * (2 * static_cast<float>(i) + 1) - x, 0.06F + h * (2 * static_cast<float>(j) + 1),
                      z + 0.012F};
      add_part(model, Stuff::any, moved(make_rounded_box({0.95F * w, 0.95F * h, 0.012F}, 0.005F), c));
      const Vec3 grip = c + Vec3{knobs ? 0.7F * w : 0, 0, 0.03F};
      if (knobs)
        add_part(model, Stuff::metal, placed(make_sphere(2), grey(0.018F), {}, grip));
      else
        add_part(model, Stuff::metal,
                 make_rod(grip - Vec3{0.35F * w, 0, 0}, grip + Vec3{0.35F * w, 0, 0}, 0.008F, 8));
    }
  return model;
}

Model make_bookshelf(RandomStream& random) {
  Model model;
  const float x = random.uniform(0.35F, 0.7F), z = 0.15F, pitch = random.uniform(0.28F, 0.4F), board = 0.012F;
  const int shelves = 2 + static_cast<int>(random.below(5));
  const float height = pitch * static_cast<float>(shelves);
  for (const float side : {-1.0F, 1.0F})
    add_part(model, Stuff::wood,
             make_block({side * (x + board), 0.5F * height, 0}, {board, 0.5F * height + board, z}));
  if (random.below(2) == 0)
    add_part(model, Stuff::wood, make_block({0, 0.5F * height, -z}, {x, 0.5F * height, 0.006F}));
  constexpr Stuff kCovers[] = {Stuff::paper, Stuff::cloth, Stuff::any};
  for (int i = 0; i <= shelves; ++i) {
    const float y = pitch * static_cast<float>(i);
    add_part(model, Stuff::wood, make_block({0, y, 0}, {x, board, z}));
    if (i == shelves) break;
    const float end = random.uniform(-0.5F, 1) * x;  // the row of books stops here
    for (float at = -x + 0.01F; at < end;) {
      const float half = random.uniform(0.008F, 0.028F), tall = pitch * random.uniform(0.25F, 0.42F);
      const float deep = z * random.uniform(0.6F, 0.9F),
                  lean = random.below(8) == 0 ? random.uniform(0, 0.2F) : 0;
      const Stuff cover = kCovers[random.below(3)];
      at += half + lean * tall;
      if (at + half > x) break;
      add_part(model, cover,
               placed(make_block({0, tall, 0}, {half, tall, deep}), grey(1), turned_about({0, 0, 1}, lean),
                      {at, y + board + lean * half, z - deep - 0.02F}));
      at += half + 0.002F;
    }
  }
  return model;
}

Model make_stairs(RandomStream& random) {
  Model model;
  const int steps = 4 + static_cast<int>(random.below(9));
  const float width = random.uniform(0.4F, 1), rise = random.uniform(0.14F, 0.2F),
              tread = random.uniform(0.24F, 0.34F);
  const bool open = random.below(2) == 0;
  for (int i = 0; i < steps; ++i) {
    const float k = static_cast<float>(i), top = rise * (k + 1);
    if (open)
      add_part(model, Stuff::wood, make_block({0, top - 0.02F, tread * k}, {width, 0.02F, 0.6F * tread}));
    else
      add_part(model, Stuff::stone,
               make_block({0, 0.5F * top, tread * k}, {width, 0.5F * top, 0.5F * tread}));
    for (const float side : {-1.0F, 1.0F})
      add_part(model, Stuff::metal,
               make_rod({side * (width - 0.03F), top, tread * k},
                        {side * (width - 0.03F), top + 0.8F, tread * k}, 0.01F, 6));
  }
  const float last = static_cast<float>(steps - 1);
  for (const float side : {-1.0F, 1.0F}) {
    const float x = side * (width - 0.03F);
    add_part(model, Stuff::metal,
             make_rod({x, rise + 0.8F, 0}, {x, rise * (last + 1) + 0.8F, tread * last}, 0.022F, 8));
  }
  return model;
}

Model make_spiral_stairs(RandomStream& random) {
  Model model;
  const int steps = 10 + static_cast<int>(random.below(14));
  const float rise = 0.17F, turn = random.uniform(0.3F, 0.5F), width = random.uniform(0.6F, 0.9F);
  add_part(model, Stuff::metal,
           make_rod({0, 0, 0}, {0, rise * static_cast<float>(steps) + 0.8F, 0}, 0.05F, 16));
  std::vector<Vec3> rail;
  for (int i = 0; i < steps; ++i) {
    const float k = static_cast<float>(i), top = rise * (k + 1);
    const Basis around = turned_about({0, 1, 0}, -turn * k);
    const Vec3 foot = {0.96F * width, top, 0}, hand = {0.96F * width, top + 0.8F, 0};
    add_part(model, Stuff::wood,
             placed(make_block({0.5F * width + 0.03F, top, 0}, {0.5F * width, 0.02F, 0.5F * turn * width}),
                    grey(1), around, {}));
    add_part(model, Stuff::metal, make_rod(around.to_world(foot), around.to_world(hand), 0.009F, 6));
    rail.push_back(around.to_world(hand));
  }
  add_part(model, Stuff::metal, make_tube(smooth_curve(rail, 3, false), 0.02F, 8, false));
  return model;
}

}  // namespace ld
