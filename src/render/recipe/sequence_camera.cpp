#include "render/recipe/sequence_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ld {
namespace {

constexpr float kFramesAKnot = 6;
constexpr size_t kFirst = 2;  // the knot of frame 0; the spline reaches one knot further on both sides

Vec3 random_direction(RandomStream& random) {
  const float u = random.uniform(), v = random.uniform();
  return sample_sphere(u, v);
}

/// Directions to feel around in: to the faces and corners of a cube.
std::vector<Vec3> feelers() {
  std::vector<Vec3> directions;
  for (const float x : {-1.0F, 0.0F, 1.0F})
    for (const float y : {-1.0F, 0.0F, 1.0F})
      for (const float z : {-1.0F, 0.0F, 1.0F}) {
        const float axes = std::abs(x) + std::abs(y) + std::abs(z);
        if (axes == 1 || axes == 3) directions.push_back(normalize({x, y, z}));
      }
  return directions;
}

float clearance(const PreparedScene& scene, Vec3 place, float time) {
  float nearest = std::numeric_limits<float>::infinity();
  for (const Vec3 direction : feelers())
    if (const auto surface = scene.trace({place, direction}, time))
      nearest = std::min(nearest, surface->distance);
  return nearest;
}

bool stays_clear(const PreparedScene& scene, const CameraPath& path, int64_t length, float clear) {
  const auto last = static_cast<float>(length);
  const int64_t half_frames = 2 * length + 2;  // from the frame before the first
  Vec3 before = path.at(-1).position;
  for (int64_t i = 0; i <= half_frames; ++i) {
    const float frame = 0.5F * static_cast<float>(i) - 1;
    const Vec3 here = path.at(frame).position, step = here - before;
    const float time = std::clamp(frame / last, 0.0F, 1.0F), way = ld::length(step);
    if (clearance(scene, here, time) < clear) return false;
    if (way > 0) {
      const auto hit = scene.trace({before, step / way}, time);
      if (hit && hit->distance < way) return false;
    }
    before = here;
  }
  return true;
}

/// Knots around `from` at knot kFirst: straight at first, then wandering off by half of a step each time.
std::vector<Vec3> wander(Vec3 from, Vec3 heading, float step, size_t count, RandomStream& random) {
  std::vector<Vec3> knots(count);
  for (size_t i = 0; i <= kFirst; ++i) knots[i] = from - heading * (step * static_cast<float>(kFirst - i));
  for (size_t i = kFirst + 1; i < count; ++i) {
    heading = normalize(heading + 0.5F * random_direction(random));
    knots[i] = knots[i - 1] + heading * step;
  }
  return knots;
}

}  // namespace

CameraPath::CameraPath(std::vector<Vec3> places, std::vector<Vec3> targets, Vec3 up, float frames_a_knot)
    : places_(std::move(places)), targets_(std::move(targets)), up_(up), frames_a_knot_(frames_a_knot) {}

Vec3 CameraPath::spline(const std::vector<Vec3>& knots, float frame) const {
  const float u = frame / frames_a_knot_ + static_cast<float>(kFirst);
  const size_t i = std::clamp<size_t>(static_cast<size_t>(std::max(u, 1.0F)), 1, knots.size() - 3);
  const float t = u - static_cast<float>(i), t2 = t * t, t3 = t2 * t;
  return 0.5F * (knots[i - 1] * (-t3 + 2 * t2 - t) + knots[i] * (3 * t3 - 5 * t2 + 2) +
                 knots[i + 1] * (-3 * t3 + 4 * t2 + t) + knots[i + 2] * (t3 - t2));
}

CameraPose CameraPath::at(float frame) const {
  const Vec3 place = spline(places_, frame);
  return {place, look_at(place, spline(targets_, frame), up_)};
}

CameraPath steady_path(const PreparedScene& scene, const Camera& start, Vec3 step, float angle,
                       int64_t length) {
  const float clear = 0.5F * clearance(scene, start.position, 0);
  for (float share = 1;; share = share > 0.1F ? 0.5F * share : 0) {
    std::vector<Vec3> places, targets;
    for (int64_t i = -static_cast<int64_t>(kFirst); i < length + 3; ++i) {
      const float frames = share * static_cast<float>(i);
      places.push_back(start.position + step * frames);
      targets.push_back(places.back() - rotate(start.axes.z, start.axes.y, angle * frames));
    }
    CameraPath path(std::move(places), std::move(targets), start.axes.y, 1);
    if (share == 0 || is_black(step) || stays_clear(scene, path, length, clear)) return path;
  }
}

CameraPath plan_camera_path(const PreparedScene& scene, const Camera& start, float distance, int64_t length,
                            float speed, RandomStream& random) {
  constexpr int kAttempts = 24;
  const auto frames = static_cast<float>(length);
  const auto count = static_cast<size_t>(frames / kFramesAKnot) + kFirst + 3;
  const Vec3 target = start.position - start.axes.z * distance;
  // A start that is close to something may stay so, but not come closer by half.
  const float clear = std::min(0.1F * distance, 0.5F * clearance(scene, start.position, 0));
  for (int attempt = 0;; ++attempt) {
    const float share = speed * static_cast<float>(kAttempts - attempt) / kAttempts;
    // 0.4 to 2 % of the distance a frame, 70 % of it in all at most.
    const float pace = std::min(0.004F * std::pow(5.0F, random.uniform()), 0.7F / frames);
    const float step = share * pace * kFramesAKnot * distance;
    const Vec3 local = random_direction(random);
    const Vec3 heading =
        normalize(start.axes.to_world({local.x, 0.4F * local.y, 0.5F * local.z}) + 1e-3F * start.axes.x);
    const Vec3 drift = random_direction(random);
    std::vector<Vec3> places = wander(start.position, heading, step, count, random);
    std::vector<Vec3> targets =
        wander(target, drift, 0.3F * speed * pace * kFramesAKnot * distance, count, random);
    CameraPath path(std::move(places), std::move(targets), start.axes.y, kFramesAKnot);
    if (attempt == kAttempts || stays_clear(scene, path, length, clear)) return path;
  }
}

}  // namespace ld
