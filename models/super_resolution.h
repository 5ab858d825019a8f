// Super-resolution by sub-pixel convolution: Shi et al. 2016, "Real-Time Single Image and Video
// Super-Resolution Using an Efficient Sub-Pixel Convolutional Neural Network" (ESPCN), section 3, for r = 2.
#pragma once

#include <torch/torch.h>

#include <memory>
#include <string>
#include <vector>

#include "models/edge_convolution.h"
#include "models/network_config.h"

namespace ld {

/// Every 2x2 block of pixels becomes one with four times the channels:
///   out[4 c + 2 i + j, y, x] = in[c, 2 y + i, 2 x + j].
/// [B, C, H, W] -> [B, 4 C, H / 2, W / 2], the sides rounded up: the last row and column are repeated where
/// they are odd.
torch::Tensor space_to_depth(const torch::Tensor& x);

/// Its inverse, the pixel shuffle of Shi et al. 2016, eq. 4: [B, 4 C, h, w] -> [B, C, 2 h, 2 w].
torch::Tensor depth_to_space(const torch::Tensor& x);

/// x [B, inputs, h, w] -> [B, 3, 2 h, 2 w]: a 5x5 convolution, 3x3 ones, each with its activation, and a last
/// 3x3 one to 12 channels, which are shuffled to colours. Without an activation behind it: what is predicted
/// may lie anywhere.
class SuperResolution : public torch::nn::Module {
 public:
  SuperResolution(int64_t inputs, const SuperResolutionConfig& config);

  torch::Tensor forward(const torch::Tensor& x);

  /// Makes the four sub-pixels of each colour alike, so that a new network shows no checkerboard (the start
  /// of Aitken et al. 2017, "Checkerboard artifact free sub-pixel convolution").
  void begin_without_checkerboard();

 private:
  std::vector<std::shared_ptr<EdgeConvolution>> convolutions_;
  bool tanh_;
};

}  // namespace ld
