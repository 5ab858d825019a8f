// A scene made ready for paths: surfaces from rays, and the sampling of its lights.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/trace/light_sampler.h"
#include "render/trace/ray_tracer.h"
#include "render/trace/scene.h"

namespace ld {

/// Where a ray met a surface.
struct Surface {
  Vec3 position;
  Vec3 geometric_normal, shading_normal;  // unit, on the outside of the object
  Vec3 at_open;                           // the same point of the object at shutter open
  TexturePoint texture;                   // for materials
  float distance = 0;                     // from the ray's origin
  int object = 0;                         // of Scene::objects, -1 on an area light
  int light = -1;                         // of Scene::lights, -1 elsewhere
  uint32_t triangle = 0;
};

class PreparedScene {
 public:
  /// Throws Error for a scene without surfaces or with inconsistent indices, and when Embree fails.
  explicit PreparedScene(Scene scene);

  const Scene& scene() const { return scene_; }
  RayTracer& tracer() { return *tracer_; }

  /// The nearest surface, past what its opacity lets through.
  std::optional<Surface> trace(const Ray& ray, float time) const;
  bool visible(const Ray& ray, float time, float distance) const;

  bool has_lights() const { return !lights_->empty(); }
  std::optional<LightSample> sample_light(Vec3 from, float time, float u0, float u1, float u2) const {
    return lights_->sample(scene_, from, time, u0, u1, u2);
  }

  /// Radiance that a surface sends back along a ray of this direction, with the density of sample_light for
  /// that direction. Of an area light (0 on its back); of an object, 0 where its material does not emit.
  Vec3 emitted(const Surface& surface, Vec3 direction, float& pdf) const;
  /// Of the sky or probe.
  Vec3 environment(Vec3 direction, float& pdf) const;

  /// Another look at the same scene.
  void set_camera(const Camera& camera) { scene_.camera = camera; }

  /// Multiplies the radiance of everything that shines.
  void scale_lights(float factor);

  /// The material at the surface point; of a mixed one, which of its two the ray from `to_viewer` sees.
  const Material& material_of(const Surface& surface, Vec3 to_viewer) const;

 private:
  void check() const;
  void describe(const Hit& hit, float time, Surface& surface) const;
  bool passes(const Hit& hit, const Ray& ray) const;

  Scene scene_;
  std::vector<Object> light_objects_;
  std::unique_ptr<LightSampler> lights_;
  std::unique_ptr<RayTracer> tracer_;
  bool has_opacity_ = false;
};

}  // namespace ld
