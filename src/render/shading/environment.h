// Light from infinitely far: a sky gradient with bright round patches (a sun, soft boxes), and its sampling.
#pragma once

#include <vector>

#include "render/geometry/vec3.h"

namespace ld {

/// A cone of constant radiance, added to the gradient.
struct SkyPatch {
  Vec3 direction;  // unit, towards the light
  float cos_radius = 0.999F;
  Vec3 radiance;
};

struct Sky {
  Vec3 zenith = {1, 1, 1}, horizon = {1, 1, 1}, ground = {1, 1, 1};  // radiance
  float falloff =
      0.5F;  // the gradient is elevation^falloff, elevation the sine of the angle above the horizon
  std::vector<SkyPatch> patches;

  Vec3 gradient(float elevation) const;
  Vec3 radiance(Vec3 direction) const;
};

struct SkySample {
  Vec3 direction;
  float pdf = 0;  // 1/sr
};

/// Draws directions in proportion to the gradient's luminance in bands of elevation (equal areas of the
/// sphere), and uniformly in each patch; which of them, by their share of the power.
class SkySampler {
 public:
  explicit SkySampler(const Sky& sky);

  SkySample sample(float u0, float u1, float u2) const;
  float pdf(Vec3 direction) const;
  /// Luminance integrated over the sphere.
  float power() const { return power_; }

 private:
  static constexpr int kBands = 32;

  std::vector<SkyPatch> patches_;
  std::vector<float> choice_;  // cumulative: the gradient, then each patch
  float band_cumulative_[kBands];
  float power_ = 0;
};

}  // namespace ld
