// Things turned on a lathe, and stacks of things.
#include "render/geometry/mesh_tools.h"
#include "render/geometry/sampling.h"
#include "render/random/shapes/furniture.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

/// A vessel with walls of the given thickness: the outside (from the foot's edge upwards, smoothed) and its
/// inside, which ends at `bottom`.
Mesh make_vessel(const std::vector<Vec2>& corners, float thickness, float bottom) {
  const std::vector<Vec2> outside = smooth_curve(corners, 8);
  std::vector<Vec2> profile = {{0, outside.front().y}};
  profile.insert(profile.end(), outside.begin(), outside.end());
  for (size_t i = outside.size(); i-- > 0;) {
    const Vec2 p = outside[i];
    if (p.y < bottom + thickness) break;
    profile.push_back({std::max(0.3F * thickness, p.x - thickness),
                       p.y + (i + 1 == outside.size() ? 0.3F * thickness : 0)});
  }
  profile.push_back({0, profile.back().y - thickness * 0.2F});
  return make_lathe(profile, 48);
}

}  // namespace

Model make_vase(RandomStream& random) {
  Model model;
  std::vector<Vec2> corners;
  const int count = 4 + static_cast<int>(random.below(3));
  const float height = random.uniform(0.9F, 2);
  for (int i = 0; i < count; ++i)
    corners.push_back({random.uniform(0.18F, 0.6F), height * share(i, count - 1)});
  add_part(model, Stuff::ceramic, make_vessel(corners, 0.035F, 0.05F));
  if (random.below(3) == 0) {  // twigs
    const int twigs = 3 + static_cast<int>(random.below(8));
    for (int i = 0; i < twigs; ++i) {
      const float a = random.uniform(0, 2 * kPi), lean = random.uniform(0.05F, 0.5F),
                  reach = random.uniform(0.5F, 1.2F);
      const Vec3 mouth = {0, height, 0},
                 out = {std::sin(lean) * std::cos(a), std::cos(lean), std::sin(lean) * std::sin(a)};
      add_part(model, Stuff::wood,
               make_tube(
                   smooth_curve(std::vector<Vec3>{{0, 0.2F, 0}, mouth, mouth + out * reach}, 6, false),
                   [](float t) { return 0.015F * (1.1F - t); }, 5, false));
    }
  }
  return model;
}

Model make_bottle(RandomStream& random) {
  Model model;
  const float body = random.uniform(0.18F, 0.35F), neck = random.uniform(0.06F, 0.1F),
              shoulder = random.uniform(0.5F, 1);
  const float top = shoulder + random.uniform(0.3F, 0.7F);
  const std::vector<Vec2> corners = {
      {0.9F * body, 0},        {body, 0.06F}, {body, 0.5F * shoulder},   {body, shoulder},
      {neck, shoulder + 0.2F}, {neck, top},   {1.2F * neck, top + 0.03F}};
  add_part(model, Stuff::glass, make_vessel(corners, 0.025F, 0.06F));
  if (random.below(2) == 0) {  // a label, a little off the glass
    const float r = 1.01F * body, low = 0.15F * shoulder, high = 0.7F * shoulder;
    add_part(model, Stuff::paper,
             make_surface(32, 1, kPi,
                          [&](int i, int j) {
                            const float a = 2 * kPi * 0.7F * share(i, 32);
                            return Vec3{r * std::cos(a), j == 0 ? low : high, -r * std::sin(a)};
                          }),
             false);
  }
  return model;
}

Model make_goblet(RandomStream& random) {
  Model model;
  const float foot = random.uniform(0.25F, 0.4F), stem = random.uniform(0.03F, 0.06F),
              bowl = random.uniform(0.25F, 0.45F);
  const float knee = random.uniform(0.3F, 0.7F), rim = bowl * random.uniform(0.6F, 1.1F),
              top = knee + random.uniform(0.4F, 0.8F);
  const std::vector<Vec2> corners = {
      {foot, 0}, {0.8F * foot, 0.03F}, {stem, 0.1F}, {stem, knee}, {bowl, knee + 0.3F * (top - knee)},
      {rim, top}};
  add_part(model, Stuff::glass, make_vessel(corners, 0.02F, knee));
  return model;
}

Model make_bowl(RandomStream& random) {
  Model model;
  const float depth = random.uniform(0.25F, 0.8F), lip = random.uniform(0.9F, 1.15F);
  add_part(model, Stuff::ceramic,
           make_vessel({{0.35F, 0}, {0.38F, 0.05F}, {0.8F, 0.45F * depth}, {lip, depth}}, 0.04F, 0.05F));
  return model;
}

Model make_fruit_bowl(RandomStream& random) {
  Model model = make_bowl(random);
  const int count = 4 + static_cast<int>(random.below(7));
  const float depth = bounds_of(model).high.y;
  for (int i = 0; i < count; ++i) {
    const float u = random.uniform(), v = random.uniform(), r = random.uniform(0.18F, 0.27F);
    const Vec2 at = sample_disk(u, v);
    const float y =
        0.6F * depth + 0.35F * r + 0.25F * (1 - at.x * at.x - at.y * at.y) * static_cast<float>(i % 2);
    Mesh fruit = make_sphere(3);
    for (Vec3& p : fruit.positions)
      p.y *= 1 - 0.18F * std::exp(-9 * (p.x * p.x + p.z * p.z));  // dents at the poles
    shade(fruit, kPi);
    add_part(model, i % 3 == 0 ? Stuff::leaf : Stuff::any,
             placed(fruit, grey(r), {}, {0.55F * at.x, y, 0.55F * at.y}));
  }
  return model;
}

Model make_jug(RandomStream& random) {
  Model model;
  const float belly = random.uniform(0.4F, 0.65F), mouth = random.uniform(0.2F, 0.4F),
              height = random.uniform(0.7F, 1.3F);
  const std::vector<Vec2> corners = {
      {0.3F, 0}, {belly, 0.35F * height}, {0.8F * mouth, 0.8F * height}, {mouth, height}};
  add_part(model, Stuff::ceramic, make_vessel(corners, 0.035F, 0.06F));
  const float wide = random.uniform(0.25F, 0.4F);
  add_part(model, Stuff::ceramic,
           make_tube(smooth_curve(std::vector<Vec3>{{0.9F * mouth, 0.86F * height, 0},
                                                    {mouth + wide, 0.85F * height, 0},
                                                    {belly + wide, 0.55F * height, 0},
                                                    {0.93F * belly, 0.36F * height, 0}},
                                  8, false),
                     0.045F, 10, false));
  if (random.below(2) == 0)
    add_part(model, Stuff::ceramic,
             make_tube(
                 smooth_curve(std::vector<Vec3>{{-0.9F * belly, 0.35F * height, 0},
                                                {-belly - 0.25F, 0.6F * height, 0},
                                                {-belly - 0.45F, 0.95F * height, 0}},
                              8, false),
                 [](float t) { return 0.11F - 0.06F * t; }, 14, false));
  return model;
}

Model make_column(RandomStream& random) {
  Model model;
  const float height = random.uniform(1.5F, 3), taper = random.uniform(0.8F, 1);
  if (random.below(2) == 0) {  // fluted
    add_part(
        model, Stuff::stone,
        placed(make_prism(star_outline(18, 0.92F), 0.5F * height, random.below(4) == 0 ? 1.5F : 0, taper, 24),
               {0.28F, 1, 0.28F}, {}, {0, 0.5F * height, 0}));
  } else {
    add_part(model, Stuff::stone,
             placed(make_cylinder(0.5F * height, taper, 40), {0.28F, 1, 0.28F}, {}, {0, 0.5F * height, 0}));
  }
  for (const float y : {0.03F, height - 0.03F})
    add_part(model, Stuff::stone, make_block({0, y, 0}, {0.36F, 0.06F, 0.36F}));
  for (const float y : {0.12F, height - 0.12F})
    add_part(model, Stuff::stone, placed(make_supertoroid(0.16F, 1, 1, 40), grey(0.28F), {}, {0, y, 0}));
  return model;
}

Model make_pawn(RandomStream& random) {
  Model model;
  std::vector<Vec2> corners = {{0.5F, 0}, {0.52F, 0.1F}, {0.3F, 0.2F}};
  const int beads = 2 + static_cast<int>(random.below(5));
  float y = 0.3F;
  for (int i = 0; i < beads; ++i) {
    const float gap = random.uniform(0.12F, 0.3F);
    corners.push_back({random.uniform(0.15F, 0.4F), y});
    corners.push_back({random.uniform(0.1F, 0.2F), y + gap});
    y += 2 * gap;
  }
  corners.push_back({0.25F, y});
  std::vector<Vec2> profile = {{0, 0}};
  for (const Vec2 p : smooth_curve(corners, 7)) profile.push_back(p);
  profile.push_back({0, y + 0.12F});
  add_part(model, Stuff::any, make_lathe(profile, 40));
  return model;
}

Model make_plate_stack(RandomStream& random) {
  Model model;
  const int count = 2 + static_cast<int>(random.below(6));
  const Mesh plate = make_vessel({{0.5F, 0}, {0.55F, 0.02F}, {0.75F, 0.06F}, {1, 0.13F}}, 0.03F, 0.01F);
  for (int i = 0; i < count; ++i) {
    const float x = random.uniform(-0.03F, 0.03F), z = random.uniform(-0.03F, 0.03F);
    add_part(model, Stuff::ceramic, moved(plate, {x, 0.06F * static_cast<float>(i), z}));
  }
  return model;
}

Model make_box_stack(RandomStream& random) {
  Model model;
  constexpr Stuff kStuffs[] = {Stuff::any, Stuff::paper, Stuff::wood};
  const int count = 2 + static_cast<int>(random.below(5));
  float y = 0;
  for (int i = 0; i < count; ++i) {
    const Vec3 half = {random.uniform(0.2F, 0.45F), random.uniform(0.08F, 0.3F), random.uniform(0.2F, 0.45F)};
    const Basis turn = turned_about({0, 1, 0}, random.uniform(0, kPi));
    const float x = random.uniform(-0.06F, 0.06F), z = random.uniform(-0.06F, 0.06F);
    add_part(model, kStuffs[random.below(3)],
             placed(make_block({}, half), grey(1), turn, {x, y + half.y, z}));
    y += 2 * half.y + 0.002F;
  }
  return model;
}

Model make_book_stack(RandomStream& random) {
  Model model;
  constexpr Stuff kCovers[] = {Stuff::any, Stuff::cloth, Stuff::paper};
  const int count = 2 + static_cast<int>(random.below(8));
  float y = 0;
  for (int i = 0; i < count; ++i) {
    const Vec3 half = {random.uniform(0.3F, 0.45F), random.uniform(0.03F, 0.08F),
                       random.uniform(0.2F, 0.32F)};
    const Basis turn = turned_about({0, 1, 0}, random.uniform(-0.4F, 0.4F));
    const Stuff cover = kCovers[random.below(3)];
    for (const float side : {-1.0F, 1.0F})
      add_part(model, cover,
               placed(make_block({0, side * (half.y - 0.006F), 0}, {half.x, 0.006F, half.z}), grey(1), turn,
                      {0, y + half.y, 0}));
    add_part(model, cover,
             placed(make_block({-half.x + 0.006F, 0, 0}, {0.006F, half.y, half.z}), grey(1), turn,
                    {0, y + half.y, 0}));
    add_part(model, Stuff::stone,
             placed(make_block({0, 0, 0}, {half.x - 0.02F, half.y - 0.013F, half.z - 0.02F}), grey(1), turn,
                    {0, y + half.y, 0}));
    y += 2 * half.y + 0.002F;
  }
  return model;
}

Model make_coin_stack(RandomStream& random) {
  Model model;
  const int piles = 1 + static_cast<int>(random.below(5));
  const Mesh coin = make_cylinder(0.12F, 1, 32);
  for (int k = 0; k < piles; ++k) {
    const float a = random.uniform(0, 2 * kPi), r = piles > 1 ? 2.4F : 0;
    const int coins = 3 + static_cast<int>(random.below(16));
    for (int i = 0; i < coins; ++i) {
      const float x = random.uniform(-0.08F, 0.08F), z = random.uniform(-0.08F, 0.08F);
      add_part(model, Stuff::metal,
               moved(coin, {r * std::cos(a) * share(k, piles) + x, 0.24F * static_cast<float>(i),
                            r * std::sin(a) * share(k, piles) + z}));
    }
  }
  return model;
}

Model make_crate(RandomStream& random) {
  Model model;
  const int boards = 3 + static_cast<int>(random.below(4));
  const float gap = random.uniform(0.02F, 0.06F), half = 1 / static_cast<float>(boards) - gap;
  for (int side = 0; side < 4; ++side) {
    const Basis turn = turned_about({0, 1, 0}, 0.5F * kPi * static_cast<float>(side));
    for (int i = 0; i < boards; ++i) {
      const float y = (2 * static_cast<float>(i) + 1) / static_cast<float>(boards) - 1;
      add_part(model, Stuff::wood,
               placed(make_block({0, y, 0.95F}, {0.92F, half, 0.04F}), grey(1), turn, {}));
    }
    add_part(model, Stuff::wood, placed(make_block({0.93F, 0, 0.93F}, {0.06F, 1, 0.06F}), grey(1), turn, {}));
  }
  add_part(model, Stuff::wood, make_block({0, -0.95F, 0}, {0.9F, 0.04F, 0.9F}));
  if (random.below(2) == 0) {
    const float y = 1.0F + random.uniform(0, 0.05F);
    add_part(model, Stuff::wood,
             placed(make_block({}, {1, 0.03F, 1}), grey(1),
                    turned_about({0, 1, 0}, random.uniform(-0.1F, 0.4F)), {0, y, 0}));
  }
  return model;
}

Model make_barrel(RandomStream& random) {
  Model model;
  const float bulge = random.uniform(0.05F, 0.25F);
  std::vector<Vec2> profile = {{0, -1}};
  for (int i = 0; i <= 14; ++i) {
    const float y = 2 * share(i, 14) - 1;
    profile.push_back({0.6F + bulge * (1 - y * y), y});
  }
  profile.push_back({0, 1});
  add_part(model, Stuff::wood, make_lathe(profile, 48));
  for (const float y : {-0.75F, -0.35F, 0.35F, 0.75F})
    add_part(model, Stuff::metal,
             placed(make_cylinder(1, 1, 48),
                    {0.615F + bulge * (1 - y * y), 0.04F, 0.615F + bulge * (1 - y * y)}, {}, {0, y, 0}));
  return model;
}

}  // namespace ld
