// Lamps, blinds, pictures, pipes: what hangs and stands about.
#include "render/geometry/mesh_tools.h"
#include "render/geometry/sampling.h"
#include "render/random/shapes/furniture.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

/// A shell of some thickness between two radii, open above and below.
Mesh lamp_shade(float low, float high, float height) {
  constexpr float kThickness = 0.006F;
  // A ring's profile does not touch the axis: it is a surface that closes upon itself.
  const std::vector<Vec2> profile = {
      {low, 0}, {high, height}, {high - kThickness, height}, {low - kThickness, 0}};
  return make_surface(40, 4, kCrease, [&](int i, int j) {
    const float angle = 2 * kPi * share(i % 40, 40);
    const Vec2 p = profile[static_cast<size_t>(j % 4)];
    return Vec3{p.x * std::cos(angle), p.y, -p.x * std::sin(angle)};
  });
}

}  // namespace

Model make_floor_lamp(RandomStream& random) {
  Model model;
  const float height = random.uniform(1.2F, 1.7F), low = random.uniform(0.16F, 0.28F),
              high = low * random.uniform(0.45F, 1);
  const float shade = random.uniform(0.2F, 0.35F);
  add_part(model, Stuff::metal,
           placed(make_cylinder(0.15F, 0.9F, 32), {0.14F, 0.1F, 0.14F}, {}, {0, 0.015F, 0}));
  add_part(model, Stuff::metal, make_rod({0, 0.02F, 0}, {0, height, 0}, 0.012F, 10));
  add_part(model, Stuff::cloth, moved(lamp_shade(low, high, shade), {0, height - 0.5F * shade, 0}));
  add_part(model, Stuff::bulb, placed(make_sphere(2), grey(0.05F), {}, {0, height + 0.04F, 0}));
  return model;
}

Model make_desk_lamp(RandomStream& random) {
  Model model;
  const float lower = random.uniform(0.25F, 0.4F), upper = random.uniform(0.25F, 0.4F);
  const float lean = random.uniform(0.1F, 0.6F), bow = random.uniform(0.9F, 1.7F);
  const Vec3 elbow = {lower * std::sin(lean), 0.02F + lower * std::cos(lean), 0};
  const Vec3 head = elbow + Vec3{-upper * std::sin(bow), upper * std::cos(bow) + 0.1F, 0};
  add_part(model, Stuff::metal,
           placed(make_cylinder(0.15F, 0.95F, 32), {0.1F, 0.1F, 0.1F}, {}, {0, 0.015F, 0}));
  add_part(model, Stuff::metal, make_rod({0, 0.02F, 0}, elbow, 0.009F, 8));
  add_part(model, Stuff::metal, make_rod(elbow, head, 0.009F, 8));
  add_part(model, Stuff::metal, placed(make_sphere(2), grey(0.02F), {}, elbow));
  const Basis tilt = turned_about({0, 0, 1}, random.uniform(-0.5F, 0.2F));
  add_part(model, Stuff::ceramic,
           placed(lamp_shade(0.1F, 0.04F, 0.12F), grey(1), tilt, head - Vec3{0, 0.1F, 0}));
  add_part(model, Stuff::bulb, placed(make_sphere(2), grey(0.028F), {}, head - Vec3{0, 0.06F, 0}));
  return model;
}

Model make_chandelier(RandomStream& random) {
  Model model;
  const int arms = 4 + static_cast<int>(random.below(6));
  const float radius = random.uniform(0.4F, 0.7F), sag = random.uniform(0.15F, 0.4F);
  add_part(model, Stuff::metal, make_rod({0, -0.2F, 0}, {0, 0.7F, 0}, 0.02F, 12));
  add_part(model, Stuff::metal, placed(make_sphere(3), {0.1F, 0.12F, 0.1F}, {}, {0, -0.1F, 0}));
  for (int i = 0; i < arms; ++i) {
    const float a = 2 * kPi * share(i, arms);
    const Vec3 out = {std::cos(a), 0, std::sin(a)};
    const std::vector<Vec3> arm = smooth_curve(std::vector<Vec3>{{0, -0.05F, 0},
                                                                 out * (0.5F * radius) - Vec3{0, sag, 0},
                                                                 out * radius,
                                                                 out * radius + Vec3{0, 0.08F, 0}},
                                               8, false);
    add_part(model, Stuff::metal, make_tube(arm, 0.012F, 8, false));
    add_part(
        model, Stuff::ceramic,
        placed(make_cylinder(0.3F, 0.8F, 16), {0.05F, 0.05F, 0.05F}, {}, out * radius + Vec3{0, 0.08F, 0}));
    add_part(model, Stuff::bulb,
             placed(make_sphere(2), {0.03F, 0.05F, 0.03F}, {}, out * radius + Vec3{0, 0.14F, 0}));
    add_part(model, Stuff::glass,
             placed(make_platonic(8), {0.02F, 0.06F, 0.02F}, {}, out * radius - Vec3{0, 0.1F, 0}));
  }
  return model;
}

Model make_window_blinds(RandomStream& random) {
  Model model;
  const int slats = 10 + static_cast<int>(random.below(20));
  add_part(model, Stuff::any, make_blinds(slats, random.uniform(-0.9F, 0.9F)));
  return model;
}

Model make_picture(RandomStream& random) {
  Model model;
  const float x = random.uniform(0.2F, 0.6F), y = random.uniform(0.2F, 0.6F),
              w = random.uniform(0.02F, 0.06F);
  add_part(model, Stuff::screen, make_block({0, 0, 0.005F}, {x, y, 0.006F}));
  for (const float side : {-1.0F, 1.0F}) {
    add_part(model, Stuff::wood,
             moved(make_rounded_box({x + 2 * w, w, 0.025F}, 0.008F), {0, side * (y + w), 0}));
    add_part(model, Stuff::wood, moved(make_rounded_box({w, y, 0.025F}, 0.008F), {side * (x + w), 0, 0}));
  }
  return model;
}

Model make_monitor(RandomStream& random) {
  Model model;
  const float x = random.uniform(0.25F, 0.45F), y = 0.58F * x, lift = random.uniform(0.1F, 0.2F);
  add_part(model, Stuff::any,
           moved(make_rounded_box({x + 0.012F, y + 0.012F, 0.015F}, 0.008F), {0, y + lift, 0}));
  add_part(model, Stuff::screen, make_block({0, y + lift, 0.016F}, {x, y, 0.002F}));
  add_part(model, Stuff::metal, make_rod({0, 0, -0.03F}, {0, y + lift, -0.03F}, 0.02F, 10));
  add_part(model, Stuff::metal,
           moved(make_rounded_box({0.4F * x, 0.008F, 0.1F}, 0.004F), {0, 0.008F, -0.02F}));
  return model;
}

Model make_radiator(RandomStream& random) {
  Model model;
  const int ribs = 6 + static_cast<int>(random.below(14));
  const float height = random.uniform(0.25F, 0.45F), pitch = 0.08F,
              half = 0.5F * pitch * static_cast<float>(ribs);
  for (int i = 0; i < ribs; ++i)
    add_part(model, Stuff::ceramic,
             placed(make_capsule(height, 0.03F, 12), {1, 1, 2.2F}, {},
                    {pitch * (static_cast<float>(i) + 0.5F) - half, height + 0.1F, 0}));
  for (const float y : {0.16F, 2 * height + 0.04F})
    add_part(model, Stuff::ceramic, make_rod({-half, y, 0}, {half, y, 0}, 0.02F, 10));
  return model;
}

Model make_candles(RandomStream& random) {
  Model model;
  const int count = 1 + static_cast<int>(random.below(6));
  add_part(model, Stuff::metal,
           placed(make_cylinder(0.1F, 0.95F, 40), {0.3F, 0.1F, 0.3F}, {}, {0, 0.01F, 0}));
  for (int i = 0; i < count; ++i) {
    const float a = 2 * kPi * share(i, count), r = random.uniform(0.03F, 0.06F),
                h = random.uniform(0.05F, 0.25F);
    const Vec3 at = {count > 1 ? 0.18F * std::cos(a) : 0, 0.02F, count > 1 ? 0.18F * std::sin(a) : 0};
    add_part(model, Stuff::ceramic, moved(make_rod({0, 0, 0}, {0, 2 * h, 0}, r, 20), at));
    add_part(model, Stuff::any, moved(make_rod({0, 2 * h, 0}, {0, 2 * h + 0.03F, 0}, 0.003F, 5), at));
    add_part(model, Stuff::bulb,
             placed(make_sphere(2), {0.014F, 0.04F, 0.014F}, {}, at + Vec3{0, 2 * h + 0.06F, 0}));
  }
  return model;
}

Model make_pipes(RandomStream& random) {
  Model model;
  const int runs = 2 + static_cast<int>(random.below(6));
  for (int run = 0; run < runs; ++run) {
    const float radius = random.uniform(0.015F, 0.05F);
    Vec3 at = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    uint32_t axis = random.below(3);
    const int bends = 2 + static_cast<int>(random.below(5));
    for (int i = 0; i < bends; ++i) {
      Vec3 to = at;
      to[static_cast<int>(axis)] = random.uniform(-1, 1);
      add_part(model, Stuff::metal, make_rod(at, to, radius, 14));
      add_part(model, Stuff::metal, placed(make_sphere(2), grey(1.35F * radius), {}, to));
      at = to;
      axis = (axis + 1 + random.below(2)) % 3;
    }
  }
  return model;
}

Model make_wheel(RandomStream& random) {
  Model model;
  const int spokes = 5 + static_cast<int>(random.below(20));
  const float tube = random.uniform(0.08F, 0.22F);
  add_part(model, Stuff::any, make_supertoroid(tube, random.uniform(0.4F, 1), 1, 64));
  add_part(model, Stuff::metal, placed(make_supertoroid(0.05F, 1, 1, 64), grey(1 - tube), {}, {}));
  for (int i = 0; i < spokes; ++i) {
    const float a = 2 * kPi * share(i, spokes);
    add_part(model, Stuff::metal,
             make_rod({}, {(1 - tube) * std::cos(a), 0, (1 - tube) * std::sin(a)}, 0.018F, 6));
  }
  add_part(model, Stuff::metal, placed(make_cylinder(0.8F, 0.8F, 20), {0.12F, 0.12F, 0.12F}, {}, {}));
  return model;
}

Model make_umbrella(RandomStream& random) {
  Model model;
  const int ribs = 6 + static_cast<int>(random.below(5));
  const float height = random.uniform(1.4F, 2.2F), sag = random.uniform(0.04F, 0.12F),
              drop = random.uniform(0.25F, 0.5F);
  constexpr int kAcross = 12;
  Mesh canopy = make_surface(kAcross * ribs, 12, 0.35F, [&](int i, int j) {
    const int column = i % (kAcross * ribs);
    const float a = 2 * kPi * share(column, kAcross * ribs), t = share(12 - j, 12);
    const float between = std::abs(std::sin(0.5F * static_cast<float>(ribs) * a));  // 0 on a rib
    return Vec3{t * std::cos(a) * (1 - sag * between), height - drop * t * t + sag * between * t,
                -t * std::sin(a) * (1 - sag * between)};
  });
  add_part(model, Stuff::cloth, std::move(canopy), false);
  add_part(model, Stuff::wood, make_rod({0, 0, 0}, {0, height, 0}, 0.02F, 10));
  for (int i = 0; i < ribs; ++i) {
    const float a = 2 * kPi * share(i, ribs);
    std::vector<Vec3> rib;
    for (int k = 0; k <= 8; ++k) {
      const float t = share(k, 8);
      rib.push_back({t * std::cos(a), height - drop * t * t - 0.012F, -t * std::sin(a)});
    }
    add_part(model, Stuff::metal, make_tube(rib, 0.007F, 5, false));
  }
  add_part(model, Stuff::stone,
           placed(make_cylinder(0.3F, 0.9F, 32), {0.25F, 0.2F, 0.25F}, {}, {0, 0.05F, 0}));
  return model;
}

}  // namespace ld
