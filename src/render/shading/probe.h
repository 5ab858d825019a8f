// Light from infinitely far as a picture: an equirectangular probe, and its sampling in proportion to its
// radiance.
#pragma once

#include <memory>
#include <vector>

#include "render/shading/environment.h"
#include "render/shading/texture_image.h"

namespace ld {

/// Row 0 looks to +y of `orientation`; the middle column to its -z, columns to the right to its +x.
struct Probe {
  std::shared_ptr<const TextureImage> image;  // radiance
  Basis orientation;                          // in world coordinates
  Vec3 scale = {1, 1, 1};

  /// Bilinear between texels.
  Vec3 radiance(Vec3 direction) const;
};

/// Draws directions from a density that is constant over each texel and follows the luminance of the probe
/// there (Pharr, Jakob and Humphreys 2023, section 12.5).
class ProbeSampler {
 public:
  explicit ProbeSampler(const Probe& probe);

  SkySample sample(float u0, float u1) const;
  float pdf(Vec3 direction) const;
  /// Luminance integrated over the sphere.
  float power() const { return power_; }

 private:
  float texel_pdf(size_t row, size_t column, float polar) const;

  int width_, height_;
  Basis orientation_;
  std::vector<float> rows_;     // cumulative over the rows
  std::vector<float> columns_;  // [row, column], cumulative over a row
  float power_ = 0;
};

}  // namespace ld
