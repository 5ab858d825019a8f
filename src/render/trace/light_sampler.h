// Choosing a light and a point on it: next-event estimation's half of the work.
#pragma once

#include <optional>
#include <vector>

#include "render/trace/scene.h"

namespace ld {

struct LightSample {
  Vec3 direction;      // unit, towards the light
  float distance = 0;  // infinity for sky, probe and parallel light
  Vec3 radiance;       // as if nothing stood between; of a delta light, radiance times solid angle
  float pdf = 0;       // 1/sr, the choice of the light included; of a delta light, the choice alone
  bool delta = false;  // point and parallel lights, which no scattered ray can find
};

/// All lights of a scene: area lights, every triangle that emits, point and parallel lights, sky or probe.
/// Half of the choices go by power, with light from afar counted as what a disk receives whose radius is the
/// distance of the local lights from where the camera looks; the other half is shared out evenly among the
/// kinds of light, for power says little about a sky that is seen through a window.
class LightSampler {
 public:
  explicit LightSampler(const Scene& scene);

  bool empty() const { return choice_.empty(); }

  /// Lights of `scene`, which may have been scaled since. Empty when the point faces away from the light
  /// chosen.
  std::optional<LightSample> sample(const Scene& scene, Vec3 from, float time, float u0, float u1,
                                    float u2) const;

  /// Density with which sample() draws the direction in which a light lies; 0 where there is nothing to draw.
  float area_light_pdf(size_t light, float distance, float cos_light) const;
  float triangle_pdf(size_t object, size_t triangle, float distance, float cos_light) const;
  float environment_pdf(Vec3 direction) const;

 private:
  struct EmissiveTriangle {
    size_t object, triangle;
    float area;
  };

  struct AreaGeometry {
    Vec3 normal;
    float area;
  };

  void add_powers(const Scene& scene);
  std::optional<LightSample> sample_area_light(const AreaLight& light, size_t i, Vec3 from, float u1,
                                               float u2) const;
  std::optional<LightSample> sample_triangle(const Scene& scene, const EmissiveTriangle& which, float chosen,
                                             Vec3 from, float time, float u1, float u2) const;

  std::vector<AreaGeometry> areas_;  // of the area lights
  std::vector<EmissiveTriangle> triangles_;
  std::vector<int64_t> first_triangle_;  // [object] index into triangles_, -1 where it does not emit
  std::optional<SkySampler> sky_;
  std::optional<ProbeSampler> probe_;
  size_t first_point_ = 0, first_parallel_ = 0, environment_ = 0, first_emitter_ = 0;  // into choice_
  std::vector<float> choice_;  // cumulative: area, point, parallel lights, sky or probe, emitting triangles
};

}  // namespace ld
