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
///
/// Without a gradient to keep, the blocks of full resolution run in strips of rows, widened by the reach of
/// their convolutions: at 1920x1080 they alone would take 5 GB, everything coarser together takes less than
/// 1 GB. Tiles of the whole U-net would have to overlap by its reach of 160 pixels. There the convolutions
/// also have their channels last in memory, which makes them 1.05 to 1.2 times as fast (oneDNN, AVX-512; a
/// training step gains nothing): inference and training differ by rounding.
class UNet : public torch::nn::Module {
 public:
  /// The configuration has as many decoder as encoder blocks, none of them empty (checked by make_network).
  UNet(int64_t inputs, const UNetConfig& config);

  /// [B, inputs, H, W] -> context features [B, context, H, W], H and W from 1: padded to the multiple that
  /// the pools need by repeating the last row and column, and cropped again.
  torch::Tensor forward(const torch::Tensor& input) { return features(input, 1)[0]; }

  /// What the decoder knows at full resolution (the context), 1/2, 1/4, ...: the outputs of its blocks, and
  /// of the bottleneck as the coarsest one. Entry i is [B, feature_channels(i), ceil(H / 2^i), ceil(W /
  /// 2^i)].
  std::vector<torch::Tensor> features(const torch::Tensor& input, int64_t resolutions);

  /// The resolutions that features() has, and the channels of each.
  static int64_t resolutions(const UNetConfig& config) { return int64_t(config.decoder.size()) + 1; }
  static int64_t feature_channels(const UNetConfig& config, int64_t resolution);

 private:
  torch::nn::Sequential make_block(int64_t inputs, const std::vector<int64_t>& widths) const;
  torch::Tensor upsample(const torch::Tensor& x) const;
  torch::Tensor encode_finest(const torch::Tensor& input);
  torch::Tensor decode_finest(const torch::Tensor& coarse, const torch::Tensor& skip, int64_t height,
                              int64_t width);

  UNetConfig config_;
  std::vector<torch::nn::Sequential> encoder_, decoder_;
  torch::nn::Sequential bottleneck_{nullptr};
  torch::nn::Conv2d context_{nullptr};
};

}  // namespace ld
