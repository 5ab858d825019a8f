#include "models/unet.h"

#include "ops/kernels/constants.h"

namespace ld {

using torch::Tensor;
namespace nn = torch::nn;

namespace {

/// The block on `x`, whose memory is free as soon as the first layer has read it.
Tensor run(nn::Sequential& block, Tensor x) {
  for (auto& layer : *block) x = layer.forward<Tensor>(x);
  return x;
}

/// What of a padded picture at 1 / 2^resolution belongs to the input.
Tensor cropped(const Tensor& x, const Tensor& input, int64_t resolution) {
  const auto scaled = [&](int64_t n) { return (n + (int64_t(1) << resolution) - 1) >> resolution; };
  return x.narrow(2, 0, scaled(input.size(2))).narrow(3, 0, scaled(input.size(3))).contiguous();
}

}  // namespace

UNet::UNet(int64_t inputs, const UNetConfig& config) : config_(config) {
  std::vector<int64_t> skips;  // channels of the skips, finest first
  int64_t channels = inputs;
  for (const auto& widths : config.encoder) {
    skips.push_back(channels);
    encoder_.push_back(
        register_module("encoder" + std::to_string(encoder_.size()), make_block(channels, widths)));
    channels = widths.back();
  }
  bottleneck_ = register_module("bottleneck", make_block(channels, config.bottleneck));
  channels = config.bottleneck.back();
  for (const auto& widths : config.decoder) {
    const std::string name = "decoder" + std::to_string(decoder_.size());
    decoder_.push_back(register_module(name, make_block(channels + skips.back(), widths)));
    channels = widths.back();
    skips.pop_back();
  }
  context_ = register_module("context", std::make_shared<Convolution>(channels, config.context));
}

nn::Sequential UNet::make_block(int64_t inputs, const std::vector<int64_t>& widths) const {
  nn::Sequential block;
  for (const int64_t width : widths) {
    block->push_back(std::make_shared<Convolution>(inputs, width));
    block->push_back(nn::LeakyReLU(nn::LeakyReLUOptions().negative_slope(kLeakySlope).inplace(true)));
    inputs = width;
  }
  return block;
}

int64_t UNet::feature_channels(const UNetConfig& config, int64_t resolution) {
  if (resolution == 0) return config.context;
  const int64_t blocks = int64_t(config.decoder.size());
  return resolution == blocks ? config.bottleneck.back()
                              : config.decoder[size_t(blocks - 1 - resolution)].back();
}

Tensor UNet::upsample(const Tensor& x) const {
  const std::vector<int64_t> size = {2 * x.size(2), 2 * x.size(3)};
  return config_.upsampling == "bilinear" ? at::upsample_bilinear2d(x, size, /*align_corners=*/false)
                                          : at::upsample_nearest2d(x, size);
}

/// To the multiple that the pools need; with its channels last where no gradient is kept.
Tensor UNet::padded(const Tensor& input) const {
  const int64_t multiple = int64_t(1) << encoder_.size();
  const auto missing = [&](int64_t n) { return (multiple - n % multiple) % multiple; };
  const int64_t right = missing(input.size(3)), below = missing(input.size(2));
  const Tensor x = right + below > 0 ? at::replication_pad2d(input, {0, right, 0, below}) : input;
  return at::GradMode::is_enabled() ? x : x.contiguous(at::MemoryFormat::ChannelsLast);
}

std::vector<Tensor> UNet::features(const Tensor& input, int64_t resolutions) {
  std::vector<Tensor> features(static_cast<size_t>(resolutions)), skips;
  Tensor x = padded(input);
  for (nn::Sequential& block : encoder_) {
    skips.push_back(x);
    x = at::max_pool2d(run(block, x), 2);
  }
  x = run(bottleneck_, std::move(x));
  int64_t resolution = int64_t(decoder_.size());
  for (nn::Sequential& block : decoder_) {
    if (resolution < resolutions) features[size_t(resolution)] = cropped(x, input, resolution);
    --resolution;
    x = run(block, at::cat({upsample(x), skips.back()}, 1));
    skips.pop_back();
  }
  features[0] = cropped(context_->forward(x), input, 0);
  return features;
}

}  // namespace ld
