// Super-resolution and denoising in two stages, after Arjun Arora and others, who trained such on renders of
// Falcor (github.com/Arjun-Arora/GettingStartedWithRTXRayTracing, experiments 2a to 4d): light at half
// resolution and guides at full resolution go into an ESPCN, whose picture a light KPCN denoises. Network
// name "espcn_kpcn".
//
// Both work on tone-mapped light ([MH20] eq. 7); with demodulation, on that of light without its reflectance.
#include "frame/schema.h"
#include "models/demodulation.h"
#include "models/light_kpcn.h"
#include "models/networks/registry.h"
#include "models/super_resolution.h"
#include "ops/expect_tensor.h"
#include "ops/tone_map_tensor.h"
#include "ops/weighted_sum.h"

namespace ld {
namespace {

using torch::Tensor;

/// Channels of features that are no light.
int64_t guide_channels(const NetworkConfig& config) {
  return channel_count(config.features) - 3;
}

int64_t first_stage_inputs(const NetworkConfig& config) {
  const SuperResolutionConfig& stages = config.super_resolution;
  return (stages.light() ? 3 : 0) + (stages.guides() ? 4 * guide_channels(config) : 0);
}

class EspcnKpcnNetwork : public Network {
 public:
  explicit EspcnKpcnNetwork(const NetworkConfig& config)
      : Network(config),
        light_(first_channel(config.features, "half_radiance")),
        is_given_(light_ >= 0),
        super_resolution_(register_module(
            "super_resolution",
            std::make_shared<SuperResolution>(first_stage_inputs(config), config.super_resolution))),
        denoiser_(register_module(
            "denoiser", std::make_shared<LightKpcn>(guide_channels(config), config.super_resolution.denoiser,
                                                    config.kernel_size, config.logit_bound))) {
    if (!is_given_) light_ = first_channel(config.features, "radiance");
  }

 private:
  /// What is known of the pixels before the stages.
  struct Pixels {
    Tensor guides;       // means over the samples [B, G, H, W]
    Tensor light;        // tone-mapped, at half resolution [B, 3, h, w]
    Tensor reflectance;  // of full resolution, that of half of it where a pixel has no samples; or undefined
    Tensor known;        // 1 where a pixel of the half picture has light, else 0 [B, 1, H, W]
  };

  Tensor denoise(const NetworkInput& input, NetworkState& /*state*/) override {
    return make_stages(input, SecondReads::first, {}).picture;
  }

  Stages make_stages(const NetworkInput& input, SecondReads reads, const Tensor& given) override {
    const Pixels pixels = make_pixels(input);
    const Tensor first = super_resolved(pixels);
    Tensor second = reads == SecondReads::first_stopped ? first.detach() : first;
    if (reads == SecondReads::given)
      second = tone_map(pixels.reflectance.defined() ? given / pixels.reflectance : given);
    const Tensor filtered = denoiser_->forward(second, pixels.guides, log_known(pixels));
    return {relit(first, pixels) * pixels.known, relit(filtered, pixels)};
  }

  Kernels make_kernels(const NetworkInput& input) override {
    const Pixels pixels = make_pixels(input);
    return {denoiser_->logits(super_resolved(pixels), pixels.guides).unsqueeze(1),
            log_known(pixels).unsqueeze(1)};
  }

  Pixels make_pixels(const NetworkInput& input) const {
    const int64_t h = input.valid.size(3), w = input.valid.size(4);
    const auto upscaled = [&](const Tensor& half) {
      return at::upsample_nearest2d(half, {2 * half.size(2), 2 * half.size(3)})
          .narrow(2, 0, h)
          .narrow(3, 0, w);
    };
    Pixels pixels;
    const Tensor features = masked_mean(input.features, input.valid);
    pixels.guides = at::cat(
        {features.narrow(1, 0, light_), features.narrow(1, light_ + 3, features.size(1) - light_ - 3)}, 1);
    const Tensor drawn = input.valid.ne(0).any(1).to(features.scalar_type()),
                 drawn_of_four = space_to_depth(drawn), count = drawn_of_four.sum(1, /*keepdim=*/true),
                 shares = (drawn_of_four / count.clamp_min(1)).unsqueeze(1);
    /// The mean over those of 2x2 pixels that have samples.
    const auto halved = [&](const Tensor& x) {
      return (space_to_depth(x).unflatten(1, {-1, 4}) * shares).sum(2);
    };
    pixels.known = upscaled(count.gt(0).to(features.scalar_type()));
    const bool demodulates = input.demodulator.defined();
    if (is_given_) {
      pixels.light = halved(features.narrow(1, light_, 3));
      if (demodulates) pixels.light = tone_map_inverse(pixels.light);
    } else {
      const Tensor radiance = input.radiance.narrow(2, input.radiance.size(2) - 3, 3);
      pixels.light = halved(masked_mean(radiance, input.valid)).clamp_max(kHalfMax);
    }
    if (demodulates) {
      const Tensor own = masked_mean(input.demodulator, input.valid);
      const Tensor half = halved(own).masked_fill(count.eq(0), 1);
      pixels.light = pixels.light / half;
      pixels.reflectance = at::where(drawn.gt(0), own, upscaled(half));
    }
    if (!is_given_ || demodulates) pixels.light = tone_map(pixels.light);
    return pixels;
  }

  /// Tone-mapped light at full resolution [B, 3, H, W].
  Tensor super_resolved(const Pixels& pixels) {
    std::vector<Tensor> inputs;
    if (config().super_resolution.light()) inputs.push_back(pixels.light);
    if (config().super_resolution.guides()) inputs.push_back(space_to_depth(pixels.guides));
    return super_resolution_->forward(at::cat(inputs, 1))
        .narrow(2, 0, pixels.known.size(2))
        .narrow(3, 0, pixels.known.size(3))
        .contiguous();
  }

  static Tensor log_known(const Pixels& pixels) {
    return at::zeros_like(pixels.known).masked_fill(pixels.known.eq(0), -kInfinity).squeeze(1);
  }

  /// Linear radiance from tone-mapped light.
  static Tensor relit(const Tensor& light, const Pixels& pixels) {
    const Tensor linear = tone_map_inverse(light);
    return pixels.reflectance.defined() ? linear * pixels.reflectance : linear;
  }

  int64_t light_;  // first channel of the light among the features
  bool is_given_;  // at half resolution, or made of radiance
  std::shared_ptr<SuperResolution> super_resolution_;
  std::shared_ptr<LightKpcn> denoiser_;
};

}  // namespace

std::shared_ptr<Network> make_espcn_kpcn_network(const NetworkConfig& config) {
  return std::make_shared<EspcnKpcnNetwork>(config);
}

}  // namespace ld
