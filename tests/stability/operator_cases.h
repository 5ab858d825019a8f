// Every operator of src/ops as the stability suite calls it: the list that its tests walk. A new operator is
// one entry here.
#pragma once

#include <torch/torch.h>

#include <functional>
#include <string>
#include <vector>

namespace ld {

struct OperatorInput {
  std::string name;
  torch::Tensor ordinary;  // float32, numbers of order 1
  bool any_number;         // the header says what NaN and infinities mean
  double largest;          // of the finite numbers that the header admits
};

struct OperatorCase {
  std::string name;
  std::vector<OperatorInput> inputs;  // all differentiable
  /// The results, flattened to one tensor; takes float32 and float64. Where a log n is -inf or so low that
  /// no exponential tells it from that, it counts as 0.
  std::function<torch::Tensor(const std::vector<torch::Tensor>&)> run;
};

/// On pictures of 11x9 with 3 samples, 2 layers, 5x5 kernels.
std::vector<OperatorCase> operator_cases();

/// 0, denormals, half's and float's largest numbers, negative ones, NaN and the infinities.
const std::vector<float>& extreme_numbers();

/// `ordinary` with `number` in about a fifth of its places.
torch::Tensor sprinkle(const torch::Tensor& ordinary, float number, uint32_t seed);

}  // namespace ld
