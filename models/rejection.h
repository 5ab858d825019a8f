// Rejection: a pixel that holds a firefly can send less than others to all of its neighbours and to itself.
// In ops/kernel_splat.h the largest tap of every pixel weighs the same, so that a value of 10,000 among 81
// pixels leaves a spot of more than 100, whatever the kernels.
#pragma once

#include <torch/torch.h>

#include "models/fully_connected_module.h"
#include "models/network_config.h"
#include "models/network_numbers.h"

namespace ld {

/// What a pixel's layer (or sample, or the pixel itself) with embedding E and context C counts for:
///   log n' = log n - 16 sigmoid(w . [E, C] + b).
/// Only differences between neighbours matter, since a filter divides by the sum of its weights: no pixel is
/// left without a value, and the same rejection everywhere changes nothing.
class Rejection : public torch::nn::Module {
 public:
  explicit Rejection(const NetworkConfig& config)
      : weight_(register_module(
            "weight", std::make_shared<FullyConnected>(
                          std::vector<int64_t>{config.sample_reducer.back() + config.unet.context, 1},
                          LastLayer::linear))) {}

  /// log_n [B, N, H, W], embedding [B, N, E, H, W], context [B, C, H, W] -> log n' [B, N, H, W].
  torch::Tensor weighed(const torch::Tensor& log_n, const torch::Tensor& embedding,
                        const torch::Tensor& context) const {
    const torch::Tensor logit = with_bounded_gradient(weight_->forward(embedding, context).squeeze(2));
    return log_n - kMostRejected * at::sigmoid(logit);
  }

  /// Weights to begin with: all pixels count the same.
  void initialise() {
    const torch::NoGradGuard no_gradient;
    torch::Tensor weights = weight_->weights().weights[0], bias = weight_->weights().biases[0];
    weights.zero_();
    bias.fill_(-4);
  }

 private:
  std::shared_ptr<FullyConnected> weight_;
};

}  // namespace ld
