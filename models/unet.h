// The U-net of [MH20] figure 3: context features of each pixel from the averaged embeddings of its
// surroundings.
#pragma once

#include <torch/torch.h>

#include <vector>

#include "models/network_config.h"

namespace ld {

/// Encoder blocks of 3x3 convolutions with leaky ReLU, a 2x2 max-pool after each; a bottleneck block; decoder
/// blocks, each on the result so far scaled up by 2 and concatenated with the skip of that resolution; a last
/// 3x3 convolution without activation. A skip is the pooled output of the encoder block whose resolution it
/// has, the finest one the U-net's own input.
class UNet : public torch::nn::Module {
 public:
  /// The configuration has as many decoder as encoder blocks, none of them empty (checked by make_network).
  UNet(int64_t inputs, const UNetConfig& config);

  /// [B, inputs, H, W] -> [B, context, H, W], H and W from 1: padded to the multiple that the pools need by
  /// repeating the last row and column, and cropped again.
  torch::Tensor forward(const torch::Tensor& input);

 private:
  torch::nn::Sequential make_block(int64_t inputs, const std::vector<int64_t>& widths) const;
  torch::Tensor upsample(const torch::Tensor& x) const;

  bool bilinear_;
  std::vector<torch::nn::Sequential> encoder_, decoder_;
  torch::nn::Sequential bottleneck_{nullptr};
  torch::nn::Conv2d context_{nullptr};
};

}  // namespace ld
