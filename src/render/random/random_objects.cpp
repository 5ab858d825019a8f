#include "render/random/random_objects.h"

#include "render/geometry/sampling.h"
#include "render/random/random_materials.h"

namespace ld {
namespace {

/// A shape of about unit radius.
Mesh random_shape(RandomStream& random, Vec3& scale, bool& upright) {
  const uint32_t kind = random.below(4);
  upright = false;
  switch (kind) {
    case 0:  // ball, sometimes an ellipsoid
      if (chance(random, 0.3))
        scale = {random.uniform(0.5F, 1), random.uniform(0.5F, 1), random.uniform(0.5F, 1)};
      return make_sphere(3);
    case 1:
      scale = {random.uniform(0.3F, 0.7F), random.uniform(0.3F, 0.8F), random.uniform(0.3F, 0.7F)};
      upright = chance(random, 0.6);
      return make_box();
    case 2: {
      const float tube = random.uniform(0.15F, 0.45F);
      scale = grey(1 / (1 + tube));
      upright = chance(random, 0.4);
      return make_torus(tube, 32, 16);
    }
    default: {
      const float amplitude = random.uniform(0.15F, 0.6F), frequency = random.uniform(0.8F, 2.5F);
      const uint32_t seed = random.bits();
      scale = grey(0.9F);
      return make_blob(amplitude, frequency, 1 + static_cast<int>(random.below(3)), seed, 3);
    }
  }
}

}  // namespace

void add_random_objects(Scene& scene, const Stage& stage, int count, RandomStream& random) {
  struct Ball {
    Vec3 centre;
    float radius;
  };
  std::vector<Ball> taken;
  const auto is_free = [&](const Ball& ball) {
    if (length(ball.centre - stage.camera) < ball.radius + stage.clear) return false;
    for (const Ball& other : taken)
      if (length(ball.centre - other.centre) < 0.85F * (ball.radius + other.radius)) return false;
    return true;
  };
  constexpr int kTries = 30;  // then the object is left out: the stage is crowded
  for (int i = 0; i < count; ++i) {
    Ball ball;
    bool found = false;
    const bool floats = chance(random, stage.floating);
    for (int t = 0; t < kTries && !found; ++t) {
      ball.radius = log_uniform(random, stage.smallest, stage.largest);
      const float u = random.uniform(), v = random.uniform(), w = random.uniform();
      ball.centre.x = stage.low.x + ball.radius + u * (stage.high.x - stage.low.x - 2 * ball.radius);
      ball.centre.z = stage.low.z + ball.radius + v * (stage.high.z - stage.low.z - 2 * ball.radius);
      const float floor = stage.floor(ball.centre.x, ball.centre.z);
      ball.centre.y = floor + ball.radius;
      if (floats) ball.centre.y += w * std::max(0.0F, stage.high.y - floor - 2 * ball.radius);
      found = is_free(ball);
    }
    if (!found) continue;
    Object object;
    Vec3 scale = grey(1);
    bool upright = false;
    object.mesh = random_shape(random, scale, upright);
    Basis turn = random_rotation(random);
    if (upright) turn = {normalize(Vec3{turn.x.x, 0, turn.x.z + 1e-3F}), {0, 1, 0}, {}};
    if (upright) turn.z = cross(turn.x, turn.y);
    place(object.mesh, scale * ball.radius, turn, ball.centre);
    if (!floats) {  // let it down until it touches the floor
      float lowest = object.mesh.positions[0].y;
      for (const Vec3& p : object.mesh.positions) lowest = std::min(lowest, p.y);
      const float drop = lowest - stage.floor(ball.centre.x, ball.centre.z);
      for (Vec3& p : object.mesh.positions) p.y -= drop;
      ball.centre.y -= drop;
    }
    object.material = static_cast<int>(scene.materials.size());
    scene.materials.push_back(random_material(random, ball.radius));
    scene.objects.push_back(std::move(object));
    taken.push_back(ball);
  }
}

}  // namespace ld
