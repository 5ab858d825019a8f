// The nearest hit and the visibility of a ray, by Embree, which is in a module (core/module.h): its 44 MB are
// for who renders, not for who reads a recipe. All that depends on Embree is in embree_module.cpp.
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
/// built, so any number of threads may ask it.
class RayTracer {
 public:
  /// Loads the module at the first call. Throws Error when it is missing or Embree fails.
  static std::unique_ptr<RayTracer> build(const std::vector<const Object*>& objects);
  virtual ~RayTracer() = default;
  RayTracer(const RayTracer&) = delete;
  RayTracer& operator=(const RayTracer&) = delete;

  /// The nearest hit beyond `nearest`; false when there is none.
  virtual bool intersect(const Ray& ray, float time, Hit& hit, float nearest = 0) const = 0;
  /// Whether anything lies between 0 and `distance` (both ends excluded).
  virtual bool occluded(const Ray& ray, float time, float distance) const = 0;

  /// Notes every question in `log` until called with nullptr; one thread only may ask meanwhile.
  void record(std::vector<RecordedRay>* log) { log_ = log; }

 protected:
  RayTracer() = default;
  std::vector<RecordedRay>* log_ = nullptr;
};

/// What the module gives.
class RayTracerMaker {
 public:
  virtual ~RayTracerMaker() = default;
  virtual std::unique_ptr<RayTracer> build(const std::vector<const Object*>& objects) const = 0;
};

}  // namespace ld
