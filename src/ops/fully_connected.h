// A fully connected network of leaky ReLU layers, applied to every sample or layer of every pixel: what
// [MH20] appendix B implements "with 1x1 convolutions". Those run far below the speed of a matrix product;
// here tiles of pixels pass through all layers while they are in the cache, and only the input is kept for
// the backward pass.
#pragma once

#include <torch/torch.h>

#include <vector>

namespace ld {

struct FullyConnectedWeights {
  std::vector<torch::Tensor> weights;  // [outputs, inputs] of each layer
  std::vector<torch::Tensor> biases;   // [outputs]
  double bound = 0;  // c: what a last layer without activation puts out becomes c x / (c + |x|); 0: stays x
};

/// a_0 = [x, shared], a_i = leaky_relu(weights_i a_(i-1) + biases_i, 0.01); the last layer has no activation
/// unless `activate_last`, and may have a bound, which keeps
/// it within (-c, c) and whose slope (c / (c + |x|))^2 falls off slowly enough to come back from. x [B, S, X,
/// H, W]; shared [B, Y, H, W] is the same for all S (context features) and may be undefined (Y = 0);
/// weights_1 has X + Y inputs. Result [B, S, outputs, H, W]. float32 or float64, differentiable in x, shared
/// and the weights; the bits do not depend on the thread count. Throws Error on shapes that do not fit.
torch::Tensor fully_connected(const torch::Tensor& x, const torch::Tensor& shared,
                              const FullyConnectedWeights& network, bool activate_last);

}  // namespace ld
