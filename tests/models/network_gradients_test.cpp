// The gradients of whole networks through the float32 kernels, against LibTorch's own operators in double.
#include <gtest/gtest.h>

#include "models/network.h"
#include "tests/models/small_network.h"

namespace ld {
namespace {

using torch::Tensor;

/// Of a weighted sum of the picture.
std::vector<Tensor> gradients_of(Network& network, const NetworkInput& input, const Tensor& weights) {
  return torch::autograd::grad({(network.forward(input) * weights).sum()}, network.parameters(), {},
                               /*retain_graph=*/false, /*create_graph=*/false, /*allow_unused=*/true);
}

TEST(NetworkGradients, OfTheKernelsAreThoseInDouble) {
  for (NetworkConfig config : every_config())
    for (const auto& [height, width] : {std::pair<int64_t, int64_t>{12, 17}, {9, 33}}) {
      const auto network = small_network(config, torch::kFloat32);
      const auto exact = small_network(config, torch::kFloat64);
      {
        const torch::NoGradGuard no_gradient;
        const auto from = network->parameters(), to = exact->parameters();
        for (size_t i = 0; i < from.size(); ++i) Tensor(to[i]).copy_(from[i]);
      }
      const NetworkInput input = random_input(config, 2, 3, height, width, torch::kFloat32);
      const Tensor weights = random_normal({2, 3, height, width}, 9);
      const std::vector<Tensor> found = gradients_of(*network, input, weights.to(torch::kFloat32)),
                                expected = gradients_of(*exact, to_type(input, torch::kFloat64),
                                                        weights.to(torch::kFloat64));
      double largest = 0;
      for (const Tensor& gradient : expected)
        if (gradient.defined()) largest = std::max(largest, gradient.abs().max().item<double>());
      const auto names = network->named_parameters().keys();
      for (size_t i = 0; i < found.size(); ++i) {
        ASSERT_EQ(found[i].defined(), expected[i].defined()) << names[i];
        if (!found[i].defined()) continue;
        const double error = (found[i].to(torch::kFloat64) - expected[i]).abs().max().item<double>(),
                     own = expected[i].abs().max().item<double>();
        // The second part for the bias of rejection, whose gradient is what is left of large ones: the same
        // rejection everywhere changes nothing.
        EXPECT_LE(error, 1e-4 * own + 5e-6 * largest) << title(config) << ", " << names[i];
      }
    }
}

}  // namespace
}  // namespace ld
