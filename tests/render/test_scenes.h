// Small scenes whose truth is known, and statistics on estimates.
#pragma once

#include <cmath>
#include <cstdint>

#include "render/trace/path_tracer.h"

namespace ld {

inline Material plain_material(MaterialKind kind, Vec3 colour, float roughness = 1) {
  Material material;
  material.kind = kind;
  material.colour.colour_a = material.colour.colour_b = colour;
  material.roughness = roughness;
  return material;
}

inline Sky constant_sky(float radiance) {
  Sky sky;
  sky.zenith = sky.horizon = sky.ground = grey(radiance);
  return sky;
}

/// A camera at `position` looking at `target`, a pinhole, square.
inline Camera simple_camera(Vec3 position, Vec3 target, float fov, int size) {
  Camera camera;
  camera.position = position;
  camera.axes = look_at(position, target, {0, 1, 0});
  camera.fov = fov;
  camera.width = camera.height = size;
  return camera;
}

struct Estimate {
  double mean = 0;
  double error = 0;  // standard error of the mean
};

/// Mean luminance over the whole picture and `spp` samples of each pixel.
inline Estimate mean_luminance(const PreparedScene& scene, const PathSettings& settings, int spp,
                               uint64_t seed) {
  const Camera& camera = scene.scene().camera;
  double sum = 0, squares = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      for (int s = 0; s < spp; ++s) {
        SampleNumbers numbers(RandomStream(seed, RandomPurpose::test,
                                           static_cast<uint32_t>(y * camera.width + x),
                                           static_cast<uint32_t>(s)));
        const CameraSample where = draw_camera_sample(camera, x, y, numbers);
        const double v = luminance(trace_path(scene, camera.ray(where), where.time, numbers, settings));
        sum += v;
        squares += v * v;
      }
  const double n = static_cast<double>(camera.width) * camera.height * spp;
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1))};
}

/// How many standard errors lie between two independent estimates.
inline double z_score(const Estimate& a, const Estimate& b) {
  return std::abs(a.mean - b.mean) / std::sqrt(a.error * a.error + b.error * b.error + 1e-30);
}

}  // namespace ld
