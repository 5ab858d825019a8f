// The fully connected networks of [MH20] (sample reducer, sample partitioner, kernel generator): weights and
// layers. The arithmetic is ops/fully_connected.h.
#pragma once

#include <torch/torch.h>

#include <vector>

#include "ops/fully_connected.h"

namespace ld {

/// Of a logit that chooses between radiances. Where these are near the largest float the gradient is 1e30
/// (models/network.h), of which the embeddings, up to 1e10, make the weights': their product must not
/// overflow.
inline torch::Tensor with_bounded_gradient(const torch::Tensor& logit) {
  if (logit.requires_grad())
    logit.register_hook([](const torch::Tensor& gradient) { return gradient.clamp(-1e20, 1e20); });
  return logit;
}

enum class LastLayer { activated, linear };

/// Layers of the given widths {inputs, hidden..., outputs}. Parameters: 0.weight [outputs, inputs],
/// 0.bias, 1.weight, ...
class FullyConnected : public torch::nn::Module {
 public:
  FullyConnected(const std::vector<int64_t>& widths, LastLayer last) : last_(last) {
    for (size_t i = 0; i + 1 < widths.size(); ++i) {
      auto layer = register_module(std::to_string(i), std::make_shared<torch::nn::Module>());
      weights_.weights.push_back(
          layer->register_parameter("weight", torch::zeros({widths[i + 1], widths[i]})));
      weights_.biases.push_back(layer->register_parameter("bias", torch::zeros({widths[i + 1]})));
    }
  }

  /// x [B, S, X, H, W] and, for a network that has them, context features [B, Y, H, W]: [B, S, outputs, H,
  /// W].
  torch::Tensor forward(const torch::Tensor& x, const torch::Tensor& context = {}) const {
    return fully_connected(x, context, weights_, last_ == LastLayer::activated);
  }

  /// Whether the last layer is activated.
  LastLayer last() const { return last_; }

  /// The parameters as the operators take them.
  const FullyConnectedWeights& weights() const { return weights_; }

 private:
  LastLayer last_;
  FullyConnectedWeights weights_;  // the registered parameters
};

}  // namespace ld
