// A kernel-predicting denoiser of three convolutions, after Bako et al. 2017, "Kernel-Predicting
// Convolutional Networks for Denoising Monte Carlo Renderings", eq. 6 and 7, made small for real time.
#pragma once

#include <torch/torch.h>

#include <memory>

#include "models/edge_convolution.h"

namespace ld {

/// colours [B, 3, H, W] and guides [B, G, H, W] -> with a = relu(conv(x)) and b = relu(conv(a)) of `width`
/// channels, the logits conv(a + b) of kernel x kernel taps for each pixel, whose softmax over the taps
/// inside of the picture weighs its neighbours' colours. All convolutions are 3x3.
class LightKpcn : public torch::nn::Module {
 public:
  LightKpcn(int64_t guides, int64_t width, int64_t kernel, double logit_bound = 0);

  /// Taps in the order of ops/kernel_gather.h, [B, K*K, H, W], within the bound.
  torch::Tensor logits(const torch::Tensor& colours, const torch::Tensor& guides);

  /// log_n [B, H, W]: 0, or -inf for a pixel whose colour is not known. [B, 3, H, W], 0 where none is in
  /// reach.
  torch::Tensor forward(const torch::Tensor& colours, const torch::Tensor& guides,
                        const torch::Tensor& log_n);

  /// As KernelGenerator::begin_as_gaussian().
  void begin_as_gaussian(double sigma);

 private:
  std::shared_ptr<EdgeConvolution> first_, second_, last_;
  int64_t kernel_;
  double bound_;
};

}  // namespace ld
