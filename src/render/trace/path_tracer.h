// Unidirectional path tracing with next-event estimation and multiple importance sampling (Veach 1997; Kajiya
// 1986). No Russian roulette, and no clamping unless asked for: the estimate is then unbiased for paths of at
// most `max_bounces` scatterings.
#pragma once

#include <array>

#include "frame/schema.h"
#include "render/geometry/sample_numbers.h"
#include "render/trace/guides.h"
#include "render/trace/prepared_scene.h"

namespace ld {

/// How direct light is found. All three agree in the mean, up to what light sampling cannot see.
enum class LightStrategy { mis, light_sampling, bsdf_sampling };

struct PathSettings {
  int max_bounces = 5;  // scatterings between camera and light; 0 shows only what shines itself
  LightStrategy strategy = LightStrategy::mis;
  bool guides_through_specular = false;  // GuideRecorder
  /// Path-space regularisation (after Kaplanyan and Dachsbacher 2013, in the form that production renderers
  /// give it): once a path has been scattered broadly, every later surface has at least this roughness (GGX's
  /// alpha is its square), mirrors and smooth glass too. What can then only be found by chance, a lamp in a
  /// mirror seen by a diffuse surface, is blurred until it is found often. In [0, 1]; 0: off. Light sampling,
  /// BSDF sampling and their weights all see the same regularised surface.
  float regularisation = 0;
  /// Bound on the largest channel of every contribution that was scattered at least twice from the first
  /// surface on that is neither mirror nor smooth glass; the others are scaled with it. 0: none.
  float indirect_clamp = 0;
};

/// `contribution` scaled until its largest channel is at most `bound`; as it is where it is below already,
/// where bound is 0, and where it is not finite (a fault that must stay visible).
Vec3 clamp_contribution(Vec3 contribution, float bound);

/// Radiance in parts, whichever technique found them: by paths of one segment (what shines where the ray from
/// the camera ends), of two (camera, surface, light) and of more.
struct RadianceParts {
  Vec3 emission, direct, indirect;
};

/// Radiance along one random path that begins with `ray`; `guides`, when given, receives what the first hit
/// says, and `parts` what radiance is the sum of.
Vec3 trace_path(const PreparedScene& scene, const Ray& ray, float time, SampleNumbers& numbers,
                const PathSettings& settings, Guides* guides = nullptr, RadianceParts* parts = nullptr);

/// A uniform place on the pixel, on the lens and in the shutter interval; always takes five numbers. A
/// pinhole's lens position is (0, 0) and an instant shutter's time 0: there is nothing to know there.
CameraSample draw_camera_sample(const Camera& camera, int x, int y, SampleNumbers& numbers);

/// One sample with its guides in the channel order of frame/schema.h.
std::array<float, kAllChannels> trace_sample(const PreparedScene& scene, const CameraSample& where,
                                             SampleNumbers& numbers, const PathSettings& settings);

}  // namespace ld
