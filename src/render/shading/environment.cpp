#include "render/shading/environment.h"

#include "render/geometry/sampling.h"

namespace ld {
namespace {

float solid_angle(const SkyPatch& patch) {
  return 2 * kPi * (1 - patch.cos_radius);
}

}  // namespace

Vec3 Sky::gradient(float elevation) const {
  if (elevation >= 0) return mix(horizon, zenith, std::pow(elevation, falloff));
  return mix(horizon, ground, std::min(1.0F, -16 * elevation));  // a soft edge of under four degrees
}

Vec3 Sky::radiance(Vec3 direction) const {
  Vec3 sum = gradient(direction.y);
  for (const SkyPatch& patch : patches)
    if (dot(direction, patch.direction) >= patch.cos_radius) sum += patch.radiance;
  return sum;
}

SkySampler::SkySampler(const Sky& sky) {
  float bands[kBands];
  float gradient_power = 0, brightest = 0;
  for (int i = 0; i < kBands; ++i) {
    const float elevation = 2 * (static_cast<float>(i) + 0.5F) / kBands - 1;
    bands[i] = luminance(sky.gradient(elevation));
    gradient_power += bands[i] * 4 * kPi / kBands;
    brightest = std::max(brightest, bands[i]);
  }
  // The band's middle may miss the little light near its edge: no band may be left out.
  float total = 0;
  for (float& band : bands) total += band = std::max(band, brightest > 0 ? 0.02F * brightest : 1.0F);
  float sum = 0;
  for (int i = 0; i < kBands; ++i) band_cumulative_[i] = (sum += bands[i]) / total;

  for (const SkyPatch& patch : sky.patches)
    if (luminance(patch.radiance) > 0) patches_.push_back(patch);
  float patch_power = 0;
  for (const SkyPatch& patch : patches_) patch_power += luminance(patch.radiance) * solid_angle(patch);
  power_ = gradient_power + patch_power;
  // The gradient keeps a tenth even beside the brightest sun: its bands reach every direction.
  sum = patches_.empty() ? 1 : std::max(0.1F, gradient_power / power_);
  const float patch_share = 1 - sum;
  choice_.push_back(sum);
  for (const SkyPatch& patch : patches_)
    choice_.push_back(sum += patch_share * luminance(patch.radiance) * solid_angle(patch) / patch_power);
}

SkySample SkySampler::sample(float u0, float u1, float u2) const {
  const size_t part = choose_bin(choice_.data(), choice_.size(), u0);
  SkySample drawn;
  if (part == 0) {
    const size_t band = choose_bin(band_cumulative_, kBands, u1);
    const float y = 2 * (static_cast<float>(band) + u1) / kBands - 1;
    const float r = std::sqrt(std::max(0.0F, 1 - y * y));
    drawn.direction = {r * std::cos(2 * kPi * u2), y, r * std::sin(2 * kPi * u2)};
  } else {
    const SkyPatch& patch = patches_[part - 1];
    drawn.direction = basis_around(patch.direction).to_world(sample_cone(patch.cos_radius, u1, u2));
  }
  drawn.pdf = pdf(drawn.direction);
  return drawn;
}

float SkySampler::pdf(Vec3 direction) const {
  const auto band =
      static_cast<size_t>(std::clamp(static_cast<int>((direction.y + 1) * 0.5F * kBands), 0, kBands - 1));
  float sum = choice_[0] * bin_share(band_cumulative_, band) * kBands / (4 * kPi);
  for (size_t i = 0; i < patches_.size(); ++i)
    if (dot(direction, patches_[i].direction) >= patches_[i].cos_radius)
      sum += bin_share(choice_.data(), i + 1) / solid_angle(patches_[i]);
  return sum;
}

}  // namespace ld
