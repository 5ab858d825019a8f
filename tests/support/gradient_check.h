// The one gradient checker: autograd against central finite differences in double.
#pragma once

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "tests/support/tensors.h"

namespace ld {

/// `function` maps the inputs (float64) to any tensor, which is projected on fixed random numbers. Checks the
/// derivative in up to `elements` entries of every input that requires a gradient. Keep maxima and kinks away
/// from ties: a step is 1e-5 wide.
inline void expect_gradients(const std::function<torch::Tensor(const std::vector<torch::Tensor>&)>& function,
                             std::vector<torch::Tensor> inputs, int64_t elements = 60,
                             double tolerance = 1e-6) {
  const torch::Tensor output = function(inputs);
  const torch::Tensor projection = random_normal(output.sizes(), 99);
  const auto value = [&] {
    torch::NoGradGuard no_gradient;
    return (function(inputs) * projection).sum().item<double>();
  };
  std::vector<torch::Tensor> wanted;
  for (const torch::Tensor& input : inputs)
    if (input.requires_grad()) wanted.push_back(input);
  const auto gradients =
      torch::autograd::grad({(output * projection).sum()}, wanted, {}, /*retain_graph=*/false,
                            /*create_graph=*/false, /*allow_unused=*/false);
  for (size_t i = 0; i < wanted.size(); ++i) {
    ASSERT_TRUE(wanted[i].is_contiguous());
    const torch::Tensor gradient = gradients[i].contiguous();
    double* x = wanted[i].data_ptr<double>();
    const int64_t count = wanted[i].numel(), step = std::max<int64_t>(count / elements, 1);
    for (int64_t k = 0; k < count; k += step) {
      const double before = x[k], h = 1e-5;
      x[k] = before + h;
      const double above = value();
      x[k] = before - h;
      const double below = value();
      x[k] = before;
      const double expected = (above - below) / (2 * h), actual = gradient.data_ptr<double>()[k];
      ASSERT_LE(std::abs(actual - expected), tolerance * (1 + std::abs(expected)))
          << "input " << i << " element " << k << ": gradient " << actual << ", finite difference "
          << expected;
    }
  }
}

/// A leaf with gradient.
inline torch::Tensor variable(const torch::Tensor& t) {
  return t.detach().clone().set_requires_grad(true);
}

}  // namespace ld
