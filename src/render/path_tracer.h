// Unidirectional path tracing with next-event estimation and multiple importance sampling (Veach 1997; Kajiya
// 1986). No Russian roulette and no clamping: the estimate is unbiased for paths of at most `max_bounces`
// scatterings.
#pragma once

#include <array>

#include "frame/schema.h"
#include "render/guides.h"
#include "render/prepared_scene.h"
#include "render/sample_numbers.h"

namespace ld {

/// How direct light is found. All three agree in the mean, up to what light sampling cannot see.
enum class LightStrategy { mis, light_sampling, bsdf_sampling };

struct PathSettings {
  int max_bounces = 5;  // scatterings between camera and light; 0 shows only what shines itself
  LightStrategy strategy = LightStrategy::mis;
  bool guides_through_specular = false;  // GuideRecorder
};

/// Radiance along one random path that begins with `ray`; `guides`, when given, receives what the first hit
/// says.
Vec3 trace_path(const PreparedScene& scene, const Ray& ray, float time, SampleNumbers& numbers,
                const PathSettings& settings, Guides* guides = nullptr);

/// A uniform place on the pixel, on the lens and in the shutter interval; always takes five numbers. A
/// pinhole's lens position is (0, 0) and an instant shutter's time 0: there is nothing to know there.
CameraSample draw_camera_sample(const Camera& camera, int x, int y, SampleNumbers& numbers);

/// One sample with its guides in the channel order of frame/schema.h.
std::array<float, kSampleChannels> trace_sample(const PreparedScene& scene, const CameraSample& where,
                                                SampleNumbers& numbers, const PathSettings& settings);

}  // namespace ld
