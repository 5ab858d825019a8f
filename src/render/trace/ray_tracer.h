// The nearest hit and the visibility of a ray, by Embree. All that depends on Embree's version is in
// ray_tracer.cpp.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/geometry/camera.h"
#include "render/trace/scene.h"

namespace ld {

struct Hit {
  float distance = 0;
  uint32_t object = 0, triangle = 0;
  float u = 0, v = 0;  // the point is (1 - u - v) a + u b + v c
  Vec3 normal;         // of the triangle, not normalised, on its counter-clockwise side
};

/// A question that was put to the tracer, for measuring what it costs by itself.
struct RecordedRay {
  Ray ray;
  float time, nearest, distance;
  bool occlusion;
};

/// Acceleration structure over meshes with their motion while the shutter is open. Immutable once
/// built, so any number of threads may ask it. Throws Error when Embree fails.
class RayTracer {
 public:
  explicit RayTracer(const std::vector<const Object*>& objects);
  ~RayTracer();
  RayTracer(const RayTracer&) = delete;
  RayTracer& operator=(const RayTracer&) = delete;

  /// The nearest hit beyond `nearest`; false when there is none.
  bool intersect(const Ray& ray, float time, Hit& hit, float nearest = 0) const;
  /// Whether anything lies between 0 and `distance` (both ends excluded).
  bool occluded(const Ray& ray, float time, float distance) const;

  /// Notes every question in `log` until called with nullptr; one thread only may ask meanwhile.
  void record(std::vector<RecordedRay>* log) { log_ = log; }

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
  std::vector<RecordedRay>* log_ = nullptr;
};

}  // namespace ld
