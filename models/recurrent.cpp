#include "models/recurrent.h"

#include "frame/schema.h"
#include "models/network_numbers.h"
#include "ops/expect_tensor.h"
#include "ops/tone_map_tensor.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

namespace {

/// Channels of a feature of each sample, [B, S, C, H, W]; undefined where the network does not read it.
Tensor feature_of(const NetworkInput& input, const NetworkConfig& config, const char* name) {
  const int64_t first = first_channel(config.features, name);
  return first < 0 ? Tensor() : input.features.narrow(2, first, find_feature(name).channels);
}

/// What each sample's first hit emits, [B, S, 3, H, W].
Tensor emitted(const NetworkInput& input, const NetworkConfig& config) {
  const Tensor encoded = feature_of(input, config, "emission"), depth = feature_of(input, config, "depth");
  const Tensor own = encoded.defined() ? tone_map_inverse(encoded) : at::zeros_like(input.radiance);
  return depth.defined() ? at::where(depth.ge(1), input.radiance, own) : own;
}

Tensor replicated(const Tensor& x, int64_t multiple) {
  const auto missing = [&](int64_t n) { return (multiple - n % multiple) % multiple; };
  const int64_t right = missing(x.size(3)), below = missing(x.size(2));
  return right + below > 0 ? at::replication_pad2d(x, {0, right, 0, below}) : x;
}

}  // namespace

RecurrentInput::RecurrentInput(const NetworkInput& input, const NetworkConfig& config) {
  const torch::NoGradGuard data;
  const auto mean = [&](const Tensor& samples) { return masked_mean(samples, input.valid); };
  const Tensor like = mean(input.radiance);
  const auto mean_of = [&](const char* name) {
    const Tensor samples = feature_of(input, config, name);
    if (samples.defined()) return mean(samples);
    std::vector<int64_t> sizes = like.sizes().vec();
    sizes[1] = find_feature(name).channels;
    return at::zeros(sizes, like.options());
  };
  const Tensor none = input.valid.ne(0).any(1).logical_not();
  texture = (mean_of("albedo") + mean_of("specular")).clamp_min(kLeastTexture).masked_fill(none, 1);
  texture = texture.pow(kLightPower);
  emission = mean(emitted(input, config)).clamp_max(kLargestEmission);
  seen = at::cat({root(like), mean_of("normal").narrow(1, 0, 2), mean_of("depth"), mean_of("roughness")}, 1);
}

Tensor RecurrentInput::root(const Tensor& radiance) const {
  const torch::NoGradGuard data;
  return (radiance - (1 + kLeastBesideEmission) * emission).clamp_min(0).pow(kLightPower) / texture;
}

Tensor RecurrentInput::picture(const Tensor& predicted) const {
  const Tensor light = (predicted.clamp_min(0) * texture).clamp_max(kLargestRoot);
  return light.square().square() * light + emission;
}

LeakyConvolutions::LeakyConvolutions(int64_t inputs, const std::vector<int64_t>& widths) {
  for (const int64_t width : widths) {
    convolutions_.push_back(
        register_module(std::to_string(convolutions_.size()), std::make_shared<Convolution>(inputs, width)));
    inputs = width;
  }
}

Tensor LeakyConvolutions::forward(Tensor x) const {
  for (const auto& convolution : convolutions_) {
    x = convolution->forward(x);
    at::leaky_relu_(x, kRecurrentSlope);
  }
  return x;
}

RecurrentBlock::RecurrentBlock(int64_t width)
    : input_(
          register_module("input", std::make_shared<LeakyConvolutions>(width, std::vector<int64_t>{width}))),
      joint_(register_module(
          "joint", std::make_shared<LeakyConvolutions>(2 * width, std::vector<int64_t>{width, width}))) {}

Tensor RecurrentBlock::forward(const Tensor& input, const Tensor& before) const {
  const Tensor u = input_->forward(input);
  const Tensor h = before.defined() ? before.clamp(-kLargestState, kLargestState) : at::zeros_like(u);
  return joint_->forward(at::cat({u, h}, 1));
}

RecurrentAutoencoder::RecurrentAutoencoder(const NetworkConfig& config)
    : recurrence_(config.recurrence), bilinear_(config.unet.upsampling == "bilinear") {
  std::vector<std::vector<int64_t>> encoder = config.unet.encoder;
  encoder.push_back(config.unet.bottleneck);
  std::vector<int64_t> skips;
  int64_t channels = kRecurrentInputs;
  for (const std::vector<int64_t>& widths : encoder) {
    const std::string level = std::to_string(encoder_.size());
    encoder_.push_back(
        register_module("encoder" + level, std::make_shared<LeakyConvolutions>(channels, widths)));
    channels = widths.back();
    recurrent_.push_back(register_module("recurrent" + level, std::make_shared<RecurrentBlock>(channels)));
    skips.push_back(channels);
  }
  skips.pop_back();
  for (const std::vector<int64_t>& widths : config.unet.decoder) {
    decoder_.push_back(register_module("decoder" + std::to_string(decoder_.size()),
                                       std::make_shared<LeakyConvolutions>(channels + skips.back(), widths)));
    channels = widths.back();
    skips.pop_back();
  }
  output_ = register_module("output", std::make_shared<Convolution>(channels, 3));
}

Tensor RecurrentAutoencoder::remembered(size_t level, const Tensor& x, NetworkState& state) const {
  if (!recurrence_) return recurrent_[level]->forward(x, Tensor());
  Tensor& h = state["h" + std::to_string(level)];
  if (h.defined())
    expect_tensor("network: state", "[B, C, H, W] of the frame before", h,
                  {x.size(0), x.size(1), x.size(2), x.size(3)}, x.scalar_type());
  return h = recurrent_[level]->forward(x, h);
}

Tensor RecurrentAutoencoder::forward(const Tensor& seen, NetworkState& state) const {
  NetworkState next = state;  // a frame that fails leaves nothing
  std::vector<Tensor> skips;
  Tensor x = replicated(seen, int64_t(1) << decoder_.size());
  for (size_t level = 0; level < encoder_.size(); ++level) {
    if (level > 0) x = at::max_pool2d(x, 2);
    x = remembered(level, encoder_[level]->forward(x), next);
    skips.push_back(x);
  }
  skips.pop_back();
  for (const auto& block : decoder_) {
    const std::vector<int64_t> size = {2 * x.size(2), 2 * x.size(3)};
    const Tensor finer = bilinear_ ? at::upsample_bilinear2d(x, size, /*align_corners=*/false)
                                   : at::upsample_nearest2d(x, size);
    x = block->forward(at::cat({finer, skips.back()}, 1));
    skips.pop_back();
  }
  state = std::move(next);
  return output_->forward(x).narrow(2, 0, seen.size(2)).narrow(3, 0, seen.size(3)).contiguous();
}

}  // namespace ld
