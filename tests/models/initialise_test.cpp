// How trainings begin: the variances of names, and kernels that begin as a Gaussian.
#include "models/initialise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/models/small_network.h"

namespace ld {
namespace {

using torch::Tensor;

TEST(Initialise, HeKeepsTheSizeOfActivations) {
  NetworkConfig config;
  config.initialisation = "he";
  const auto network = make_network(config);
  initialise(*network, 7);
  for (const auto& entry : network->named_parameters()) {
    const Tensor p = entry.value().detach().to(torch::kFloat64);
    if (p.dim() == 1) continue;
    const std::string& name = entry.key();
    const bool output = name == "kernel_generator.2.weight" || name == "sample_partitioner.2.weight" ||
                        name == "unet.context.weight";
    const double taps = p.dim() == 4 ? 9 : 1, inputs = taps * double(p.size(1)),
                 outputs = taps * double(p.size(0));
    const double expected = output ? 2 / (inputs + outputs) : 2 / (1.0001 * inputs);
    EXPECT_NEAR(p.square().mean().item<double>() / expected, 1, 5 * std::sqrt(0.8 / double(p.numel())))
        << name;
  }
}

/// The kernel of the pixel in the middle, before anything is learnt.
Tensor first_kernel(NetworkConfig config) {
  config.initialisation = "he";
  const auto network = make_network(config);
  initialise(*network, 3);
  {  // what differs between pixels is left out
    const torch::NoGradGuard no_gradient;
    network->named_parameters()["kernel_generator.1.weight"].zero_();
  }
  const NetworkInput input = random_input(config, 1, 3, 9, 9, torch::kFloat32);
  const Kernels kernels = network->kernels(input);
  const Tensor exponents = (kernels.logits + kernels.log_n.unsqueeze(2)).select(4, 4).select(3, 4)[0];
  return at::softmax(exponents.flatten(), 0).view(exponents.sizes()).sum(0);  // over layers
}

TEST(Initialise, KernelsBeginAsAGaussian) {
  for (const double bound : {0.0, 8.0}) {
    NetworkConfig config = small_config();
    config.kernel_size = 7;
    config.initial_kernel = 1.5;
    config.logit_bound = bound;
    const Tensor kernel = first_kernel(config);
    const double centre = kernel[3 * 7 + 3].item<double>();
    for (int64_t tap = 0; tap < 49; ++tap) {
      const int64_t column = tap % 7, row = tap / 7;
      const double dx = double(column - 3), dy = double(row - 3), square = dx * dx + dy * dy;
      // A bounded logit falls no further than its bound.
      const double logit = bound > 0 ? std::max(-square / 4.5, -0.9 * bound - 0.5 * bound) : -square / 4.5;
      EXPECT_NEAR(kernel[tap].item<double>() / centre, std::exp(logit), 1e-4) << tap << " bound " << bound;
    }
  }
}

TEST(Initialise, WithoutItsWidthKernelsBeginAsABox) {
  const Tensor kernel = first_kernel(small_config());
  EXPECT_LE((kernel - 1.0 / 9).abs().max().item<double>(), 1e-5);
}

TEST(Initialise, OptimizedBeginsWithItsFullResolution) {
  NetworkConfig config = small_config();
  config.name = "optimized";
  config.initial_kernel = 1;
  const auto network = make_network(config);
  initialise(*network, 1);
  const Tensor bias = network->named_parameters()["kernel_generator0.1.bias"];
  EXPECT_FLOAT_EQ(bias[9].item<float>(), 3);
  EXPECT_FLOAT_EQ(bias[10].item<float>(), 0);
  EXPECT_FLOAT_EQ(bias[11].item<float>(), 0);
}

TEST(Initialise, PixelPyramidBeginsNearItsFullResolution) {
  NetworkConfig config = small_config();
  config.name = "pixel_pyramid";
  config.initial_kernel = 1;
  const auto network = make_network(config);
  initialise(*network, 1);
  const auto parameters = network->named_parameters();
  EXPECT_TRUE(parameters["levels.logits.0.weight"].eq(0).all().item<bool>());
  const Tensor bias = parameters["levels.logits.0.bias"];
  EXPECT_FLOAT_EQ(bias[0].item<float>(), 3);
  EXPECT_TRUE(bias.narrow(0, 1, bias.size(0) - 1).eq(0).all().item<bool>());
}

}  // namespace
}  // namespace ld
