#include "render/random/random_motion.h"

#include "render/geometry/sampling.h"
#include "render/random/random_materials.h"
#include "render/random/random_scene.h"

namespace ld {
namespace {

void move_camera(Camera& camera, float subject, RandomStream& random) {
  const float height = static_cast<float>(camera.height);
  // Both parts by so far on the picture, in heights of it; the shift as seen at the subject's depth.
  const float shift = log_uniform(random, 0.005F, 0.06F), swing = log_uniform(random, 0.005F, 0.06F);
  const float u = random.uniform(), v = random.uniform(), w = random.uniform();
  const Vec3 way = sample_sphere(u, v) * (shift * height * subject / camera.focal_pixels());
  const float angle = swing * height / camera.focal_pixels(), around = 2 * kPi * w;
  const Vec3 axis = camera.axes.x * std::cos(around) + camera.axes.y * std::sin(around);
  camera.close = CameraPose{camera.position + way,
                            {rotate(camera.axes.x, axis, angle), rotate(camera.axes.y, axis, angle),
                             rotate(camera.axes.z, axis, angle)}};
}

}  // namespace

void add_random_motion(Scene& scene, const std::vector<Placed>& models, const SceneConfig& config,
                       RandomStream& random) {
  Camera& camera = scene.camera;
  camera.shutter = true;
  for (const Placed& model : models) {
    const bool moves = chance(random, 0.45), turns = chance(random, config.turning),
               slides = !turns || chance(random, 0.6);
    // So far on the picture, in heights of it; mostly level, as things that stand on a floor move.
    const float shift = log_uniform(random, 0.01F, 0.12F), heading = random.uniform(0, 2 * kPi);
    const float rise = chance(random, 0.3) ? random.uniform(-0.8F, 0.8F) : 0.0F;
    const float angle = log_uniform(random, 0.04F, 0.8F) * (chance(random, 0.5) ? 1.0F : -1.0F);
    const float u = random.uniform(), v = random.uniform();
    const Vec3 middle = model.bounds.centre();
    const float depth = camera.depth(middle);
    if (!moves || depth < 0.5F) continue;
    Motion motion;
    if (slides) {
      const float pixels = shift * static_cast<float>(camera.height);
      motion.translation = normalize(Vec3{std::cos(heading), rise, std::sin(heading)}) *
                           (pixels * depth / camera.focal_pixels());
    }
    if (turns) {
      motion.axis = model.upright ? Vec3{0, 1, 0} : sample_sphere(u, v);
      motion.angle = angle;
      motion.pivot = middle;
    }
    for (size_t i = model.first; i < model.last; ++i) scene.objects[i].motion = motion;
  }
  if (chance(random, config.camera_motion)) move_camera(camera, camera.focus_distance, random);
}

float random_focus(const Scene& scene, const std::vector<Placed>& models, RandomStream& random) {
  std::vector<float> depths;
  for (const Placed& model : models) {
    const Vec3 p = model.bounds.centre();
    if (scene.camera.depth(p) < 0.5F) continue;
    const Vec2 pixel = scene.camera.project(p);
    if (pixel.x < 0 || pixel.y < 0 || pixel.x > static_cast<float>(scene.camera.width) ||
        pixel.y > static_cast<float>(scene.camera.height))
      continue;
    depths.push_back(scene.camera.depth(p));
  }
  const float fallback = random.uniform(2, 5);
  return depths.empty() ? fallback : depths[random.below(static_cast<uint32_t>(depths.size()))];
}

}  // namespace ld
