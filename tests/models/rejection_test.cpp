// Rejection: nothing where all pixels are alike, and a firefly leaves no spot.
#include "models/rejection.h"

#include <gtest/gtest.h>

#include <limits>

#include "ops/kernel_splat.h"
#include "tests/models/small_network.h"

namespace ld {
namespace {

using torch::Tensor;

/// One embedding channel, no context to speak of: rejected by `slope` times the embedding.
Rejection rejecting(double slope, double bias) {
  NetworkConfig config = small_config();
  config.sample_reducer = {1};
  config.unet.context = 1;
  Rejection rejection(config);
  const torch::NoGradGuard no_gradient;
  auto parameters = rejection.named_parameters();
  parameters["weight.0.weight"].zero_();
  parameters["weight.0.weight"].narrow(1, 0, 1).fill_(slope);
  parameters["weight.0.bias"].fill_(bias);
  return rejection;
}

TEST(Rejection, IsTheEquation) {
  const Rejection rejection = rejecting(2, -1);
  const Tensor embedding = torch::tensor({0.0F, 1.0F, -3.0F, 1e30F, -1e30F, 3e38F}).view({1, 1, 1, 1, 6});
  const Tensor log_n = torch::full({1, 1, 1, 6}, -0.5F);
  const Tensor weighed = rejection.weighed(log_n, embedding, torch::zeros({1, 1, 1, 6})).flatten();
  const auto expected = [](double logit) { return -0.5 - 16 / (1 + std::exp(-logit)); };
  EXPECT_NEAR(weighed[0].item<double>(), expected(-1), 1e-5);
  EXPECT_NEAR(weighed[1].item<double>(), expected(1), 1e-5);
  EXPECT_NEAR(weighed[2].item<double>(), expected(-7), 1e-5);
  EXPECT_EQ(weighed[3].item<double>(), -16.5);
  EXPECT_EQ(weighed[4].item<double>(), -0.5);
  EXPECT_EQ(weighed[5].item<double>(), -16.5);
  const Tensor nothing = torch::full({1, 1, 1, 6}, -std::numeric_limits<float>::infinity());
  EXPECT_TRUE(rejection.weighed(nothing, embedding, torch::zeros({1, 1, 1, 6})).equal(nothing));
}

TEST(Rejection, AsItBeginsChangesNothing) {
  for (NetworkConfig config : every_config()) {
    if (network_traits(config.name).filter != Filter::splat) {
      config.rejection = true;
      EXPECT_THROW(make_network(config), UsageError);
      continue;
    }
    config.rejection = false;
    const auto without = small_network(config, torch::kFloat64);
    config.rejection = true;
    const auto with = small_network(config, torch::kFloat64);
    const torch::NoGradGuard no_gradient;
    const auto source = without->named_parameters();
    for (auto& entry : with->named_parameters())
      if (const Tensor* value = source.find(entry.key()))
        entry.value().copy_(*value);
      else
        entry.value().fill_(entry.value().dim() == 2 ? 0 : -4);  // Rejection::initialise()
    const NetworkInput input = random_input(config, 1, 3, 9, 7, torch::kFloat64);
    EXPECT_LE(largest_difference(with->forward(input), without->forward(input)), 1e-12) << title(config);
  }
}

TEST(Rejection, AFireflyLeavesNoSpot) {
  // All kernels are boxes of 9x9; the pixel in the middle has 10,000 times the light of the others.
  Tensor light = torch::ones({1, 1, 1, 9, 9}), embedding = torch::zeros({1, 1, 1, 9, 9});
  light[0][0][0][4][4] = 1e4;
  embedding[0][0][0][4][4] = 1;
  const Tensor logits = torch::zeros({1, 1, 81, 9, 9}), log_n = torch::zeros({1, 1, 9, 9});
  const auto middle = [&](const Tensor& weights) {
    return kernel_splat(logits, weights, light)[0][0][0][4][4].item<double>();
  };
  EXPECT_GT(middle(log_n), 100);
  EXPECT_NEAR(middle(rejecting(200, -100).weighed(log_n, embedding, torch::zeros({1, 1, 9, 9}))), 1, 1e-4);
}

}  // namespace
}  // namespace ld
