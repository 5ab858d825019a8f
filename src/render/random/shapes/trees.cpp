// Trees: branches that fork, and leaves on the last ones.
#include "render/geometry/mesh_tools.h"
#include "render/geometry/sampling.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

struct Habit {
  int levels = 4, forks = 3;
  float spread = 0.6F;   // radians between a branch and its children
  float shrink = 0.72F;  // length of a child
  float gravity = 0;     // pulls the twigs down, or up when negative
  float crooked = 0.1F;
  int leaves = 8;  // on a twig
  float leaf_size = 0.1F;
  bool needles = false;
};

class Grower {
 public:
  Grower(const Habit& habit, RandomStream& random) : habit_(habit), random_(random) {
    leaf_ = habit.needles ? make_leaf(0.06F, 0.1F, 0, 2)
                          : make_leaf(random.uniform(0.25F, 0.42F), 0.7F, 0.25F, 4);
  }

  void grow(Vec3 root, Vec3 direction, float reach, float radius, int level) {
    std::vector<Vec3> curve = {root};
    constexpr int kSteps = 5;
    for (int i = 0; i < kSteps; ++i) {
      direction = normalize(direction + random_direction() * habit_.crooked -
                            Vec3{0, habit_.gravity * 0.12F * static_cast<float>(level), 0});
      curve.push_back(curve.back() + direction * (reach / kSteps));
    }
    const float tip = radius * 0.65F;
    append(plant_.stems,
           make_tube(
               curve, [&](float t) { return radius + (tip - radius) * t; }, level < 2 ? 9 : 5, false));
    if (level + 1 >= habit_.levels) {
      add_leaves(curve);
      return;
    }
    const Basis around = basis_around(direction);
    const float turn = random_.uniform(0, 2 * kPi);
    for (int k = 0; k < habit_.forks; ++k) {
      const float azimuth = turn + 2 * kPi * share(k, habit_.forks) + random_.uniform(-0.4F, 0.4F);
      const float lean = habit_.spread * random_.uniform(0.6F, 1.3F);
      const Vec3 out = around.x * std::cos(azimuth) + around.y * std::sin(azimuth);
      const Vec3 child = direction * std::cos(lean) + out * std::sin(lean);
      const size_t from = k == 0 ? curve.size() - 1 : curve.size() - 1 - random_.below(2);
      grow(curve[from], child, reach * habit_.shrink * random_.uniform(0.8F, 1.15F), tip * 0.85F, level + 1);
    }
  }

  Plant take() { return std::move(plant_); }

 private:
  Vec3 random_direction() {
    const float u = random_.uniform(), v = random_.uniform();
    return sample_sphere(u, v);
  }

  void add_leaves(const std::vector<Vec3>& twig) {
    const Vec3 along = normalize(twig.back() - twig.front());
    for (int i = 0; i < habit_.leaves; ++i) {
      const float t = share(i + 1, habit_.leaves);
      const Vec3 at = mix(twig[1], twig.back(), t);
      const Vec3 y = normalize(along * 0.4F + random_direction() * 0.9F);
      const Basis around = basis_around(y);
      append(plant_.leaves, placed(leaf_, grey(habit_.leaf_size * random_.uniform(0.6F, 1.2F)),
                                   {around.x, y, cross(around.x, y)}, at));
    }
  }

  Habit habit_;
  RandomStream& random_;
  Mesh leaf_;
  Plant plant_;
};

Plant conifer(RandomStream& random) {
  Plant plant;
  const int whorls = 9 + static_cast<int>(random.below(8));
  const float slope = random.uniform(0.1F, 0.6F), width = random.uniform(0.35F, 0.6F);
  append(plant.stems,
         make_tube(
             std::vector<Vec3>{{0, 0, 0}, {0, 2, 0}}, [](float t) { return 0.06F * (1.02F - t); }, 8, false));
  const Mesh needle = make_leaf(0.12F, 0.2F, 0, 2);
  for (int w = 0; w < whorls; ++w) {
    const float t = share(w, whorls), y = 0.25F + 1.7F * t, reach = width * (1.05F - t);
    const int branches = 7;
    for (int b = 0; b < branches; ++b) {
      const float azimuth = 2 * kPi * share(b, branches) + random.uniform(0, 0.8F);
      const Vec3 out = {std::cos(azimuth), -slope * random.uniform(0.5F, 1.2F), std::sin(azimuth)};
      const Vec3 root = {0, y, 0}, end = root + out * reach,
                 side = {-std::sin(azimuth), 0, std::cos(azimuth)};
      append(plant.stems, make_rod(root, end, 0.008F, 4));
      for (int k = 1; k <= 9; ++k)
        for (const float s : {-1.0F, 1.0F}) {
          const Vec3 v = normalize(normalize(out) * 0.8F + side * s);
          const Vec3 x = normalize(cross(v, {0, 1, 0}));
          append(plant.leaves, placed(needle, grey(0.3F * reach * random.uniform(0.7F, 1.1F)),
                                      {x, v, cross(x, v)}, mix(root, end, share(k, 9))));
        }
    }
  }
  return plant;
}

Plant palm(RandomStream& random) {
  Plant plant;
  const float lean = random.uniform(-0.4F, 0.4F), height = random.uniform(1.2F, 2.2F);
  const Vec3 top = {lean, height, 0.3F * lean};
  append(plant.stems,
         make_tube(
             smooth_curve(std::vector<Vec3>{{}, {0.1F * lean, 0.5F * height, 0}, top}, 14, false),
             [](float t) { return 0.08F - 0.03F * t + 0.006F * std::sin(120 * t); }, 9, false));
  const int fronds = 9 + static_cast<int>(random.below(7));
  const Mesh leaflet = make_leaf(0.09F, 0.4F, 0.2F, 3);
  for (int f = 0; f < fronds; ++f) {
    const float azimuth = 2 * kPi * share(f, fronds) + random.uniform(-0.2F, 0.2F),
                rise = random.uniform(0.2F, 1);
    const Vec3 level = {std::cos(azimuth), 0, std::sin(azimuth)}, side = {-level.z, 0, level.x};
    std::vector<Vec3> rib = {top};
    constexpr int kSteps = 18;
    for (int k = 1; k <= kSteps; ++k) {
      const float pitch = rise - 1.9F * share(k, kSteps);
      rib.push_back(rib.back() + (level * std::cos(pitch) + Vec3{0, std::sin(pitch), 0}) * (0.85F / kSteps));
    }
    append(plant.stems, make_tube(rib, 0.01F, 4, false));
    for (size_t k = 2; k + 1 < rib.size(); ++k)
      for (const float s : {-1.0F, 1.0F}) {
        const Vec3 v = normalize(normalize(rib[k + 1] - rib[k]) + side * s * 1.2F - Vec3{0, 0.4F, 0});
        const Vec3 x = normalize(cross(v, {0.01F, 1, 0}));
        append(plant.leaves, placed(leaflet, grey(0.32F), {x, v, cross(x, v)}, rib[k]));
      }
  }
  return plant;
}

}  // namespace

Plant make_tree(RandomStream& random) {
  const uint32_t kind = random.below(6);
  if (kind == 0) return conifer(random);
  if (kind == 1) return palm(random);
  Habit habit;
  habit.levels = 4 + static_cast<int>(random.below(2));
  habit.forks = habit.levels == 5 ? 3 : 3 + static_cast<int>(random.below(2));
  habit.spread = random.uniform(0.35F, 0.8F);
  habit.shrink = random.uniform(0.65F, 0.82F);
  habit.gravity = random.uniform(-0.5F, 1.2F);
  habit.crooked = random.uniform(0.05F, 0.3F);
  habit.leaves = random.below(6) == 0 ? 0 : habit.levels == 5 ? 9 : 14;  // now and then a bare one
  habit.leaf_size = random.uniform(0.1F, 0.2F);
  Grower grower(habit, random);
  const float trunk = random.uniform(0.45F, 0.75F), radius = random.uniform(0.05F, 0.1F);
  grower.grow({}, {0, 1, 0}, trunk, radius, 0);
  return grower.take();
}

}  // namespace ld
