// A scene made ready for paths: surfaces from rays, and the sampling of its lights.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "render/ray_tracer.h"
#include "render/scene.h"

namespace ld {

/// Where a ray met a surface.
struct Surface {
  Vec3 position;
  Vec3 geometric_normal, shading_normal;  // unit, on the outside of the object
  float distance = 0;                     // from the ray's origin
  int object = 0;                         // of Scene::objects, -1 on a light
  int light = -1;                         // of Scene::lights, -1 elsewhere
};

struct LightSample {
  Vec3 direction;      // unit, towards the light
  float distance = 0;  // infinity for the sky
  Vec3 radiance;       // as if nothing stood between
  float pdf = 0;       // 1/sr, the choice of the light included
};

class PreparedScene {
 public:
  /// Throws Error for a scene without surfaces or with inconsistent indices, and when Embree fails.
  explicit PreparedScene(Scene scene);

  const Scene& scene() const { return scene_; }

  std::optional<Surface> trace(const Ray& ray, float time) const;
  bool visible(const Ray& ray, float time, float distance) const {
    return !tracer_->occluded(ray, time, distance);
  }

  bool has_lights() const { return !choice_.empty(); }
  /// A light in proportion to its power, a point on it uniformly by area. Empty when the point faces away.
  std::optional<LightSample> sample_light(Vec3 from, float u0, float u1, float u2) const;

  /// Radiance that a ray finds on a light (0 on its back), with the density of sample_light for that
  /// direction.
  Vec3 light_radiance(const Surface& surface, Vec3 direction, float& pdf) const;
  Vec3 sky_radiance(Vec3 direction, float& pdf) const;

  /// Multiplies the radiance of every light and of the sky.
  void scale_lights(float factor);

  /// Colour of the object's material at the surface point (its pattern sticks to the moving object).
  Vec3 colour_at(const Surface& surface, float time) const;
  const Material& material_of(const Surface& surface) const;

 private:
  struct LightGeometry {
    Vec3 normal;
    float area;
  };

  Scene scene_;
  std::vector<Object> light_objects_;
  std::vector<LightGeometry> light_geometry_;
  std::optional<SkySampler> sky_sampler_;
  std::vector<float> choice_;  // cumulative over the area lights, then the sky
  std::unique_ptr<RayTracer> tracer_;
};

}  // namespace ld
