// The fully connected networks of [MH20] (sample reducer, sample partitioner, kernel generator): weights and
// layers. The arithmetic is ops/fully_connected.h.
#pragma once

#include <torch/torch.h>

#include <vector>

#include "models/parameters.h"
#include "ops/fully_connected.h"

namespace ld {

enum class LastLayer { activated, linear };

/// Layers of the given widths {inputs, hidden..., outputs}. Parameters: 0.weight [outputs, inputs],
/// 0.bias, 1.weight, ...
class FullyConnected : public torch::nn::Module {
 public:
  FullyConnected(const std::vector<int64_t>& widths, LastLayer last) : last_(last) {
    for (size_t i = 0; i + 1 < widths.size(); ++i) {
      auto layer = register_module(std::to_string(i), std::make_shared<torch::nn::Module>());
      weights_.weights.push_back(
          layer->register_parameter("weight", new_parameter({widths[i + 1], widths[i]})));
      weights_.biases.push_back(layer->register_parameter("bias", new_parameter({widths[i + 1]})));
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
