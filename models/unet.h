// The U-net of [MH20] figure 3: context features of each pixel from the averaged embeddings of its
// surroundings.
#pragma once

#include <torch/torch.h>

#include <memory>
#include <vector>

#include "models/network_config.h"

namespace ld {

/// 3x3, zeros beyond the border. (LibTorch's own module would draw random weights that nobody uses, from its
/// global generator.) Parameters: weight [outputs, inputs, 3, 3], bias [outputs].
class Convolution : public torch::nn::Module {
 public:
  Convolution(int64_t inputs, int64_t outputs)
      : weight_(register_parameter("weight", torch::zeros({outputs, inputs, 3, 3}))),
        bias_(register_parameter("bias", torch::zeros({outputs}))) {}

  torch::Tensor forward(const torch::Tensor& x) {
    return at::conv2d(x, weight_, bias_, /*stride=*/1, /*padding=*/1);
  }

 private:
  torch::Tensor weight_, bias_;
};

/// Encoder blocks of 3x3 convolutions with leaky ReLU, a 2x2 max-pool after each; a bottleneck block; decoder
/// blocks, each on the result so far scaled up by 2 and concatenated with the skip of that resolution; a last
/// 3x3 convolution without activation. A skip is the pooled output of the encoder block whose resolution it
/// has, the finest one the U-net's own input. Pictures are padded to the multiple that the pools need by
/// repeating the last row and column, and cropped again; H and W from 1.
///
/// Where no gradient is kept, the convolutions have their channels last in memory, which makes them 1.05
/// to 1.2 times as fast (oneDNN, AVX-512; a training step gains nothing): validation and training differ by
/// rounding.
class UNet : public torch::nn::Module {
 public:
  /// The configuration has as many decoder as encoder blocks, none of them empty (checked by make_network).
  UNet(int64_t inputs, const UNetConfig& config);

  /// [B, inputs, H, W] -> context features [B, context, H, W].
  torch::Tensor forward(const torch::Tensor& input) { return features(input, 1)[0]; }

  /// What the decoder knows at full resolution (the context), 1/2, 1/4, ...: the outputs of its blocks, and
  /// of the bottleneck as the coarsest one. Entry i is [B, feature_channels(i), ceil(H / 2^i), ceil(W /
  /// 2^i)].
  std::vector<torch::Tensor> features(const torch::Tensor& input, int64_t resolutions);

  /// The channels of each of the config.resolutions() that features() has.
  static int64_t feature_channels(const UNetConfig& config, int64_t resolution);

 private:
  torch::nn::Sequential make_block(int64_t inputs, const std::vector<int64_t>& widths) const;
  torch::Tensor upsample(const torch::Tensor& x) const;
  torch::Tensor padded(const torch::Tensor& input) const;

  UNetConfig config_;
  std::vector<torch::nn::Sequential> encoder_, decoder_;
  torch::nn::Sequential bottleneck_{nullptr};
  std::shared_ptr<Convolution> context_;
};

}  // namespace ld
