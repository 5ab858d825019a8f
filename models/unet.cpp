#include "models/unet.h"

namespace ld {

using torch::Tensor;
namespace nn = torch::nn;

namespace {

nn::Conv2d convolution(int64_t inputs, int64_t outputs) {
  return nn::Conv2d(nn::Conv2dOptions(inputs, outputs, 3).padding(1));
}

}  // namespace

UNet::UNet(int64_t inputs, const UNetConfig& config) : bilinear_(config.upsampling == "bilinear") {
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
  context_ = register_module("context", convolution(channels, config.context));
}

nn::Sequential UNet::make_block(int64_t inputs, const std::vector<int64_t>& widths) const {
  nn::Sequential block;
  for (const int64_t width : widths) {
    block->push_back(convolution(inputs, width));
    block->push_back(nn::LeakyReLU(nn::LeakyReLUOptions().negative_slope(0.01).inplace(true)));
    inputs = width;
  }
  return block;
}

Tensor UNet::upsample(const Tensor& x) const {
  const std::vector<int64_t> size = {2 * x.size(2), 2 * x.size(3)};
  return bilinear_ ? at::upsample_bilinear2d(x, size, /*align_corners=*/false)
                   : at::upsample_nearest2d(x, size);
}

Tensor UNet::forward(const Tensor& input) {
  const int64_t height = input.size(2), width = input.size(3), multiple = int64_t(1) << encoder_.size();
  const int64_t bottom = (multiple - height % multiple) % multiple,
                right = (multiple - width % multiple) % multiple;
  Tensor x = bottom + right == 0 ? input : at::replication_pad2d(input, {0, right, 0, bottom});

  std::vector<Tensor> skips;
  for (auto& block : encoder_) {
    skips.push_back(x);
    x = at::max_pool2d(block->forward(x), 2);
  }
  x = bottleneck_->forward(x);
  for (auto& block : decoder_) {
    x = block->forward(at::cat({upsample(x), skips.back()}, 1));
    skips.pop_back();
  }
  x = context_->forward(x);
  return x.narrow(2, 0, height).narrow(3, 0, width);
}

}  // namespace ld
