// Every registered network, weights drawn at random: extremes, constants, ranges, scaling.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "losses/loss.h"
#include "tests/models/small_network.h"
#include "tests/stability/operator_cases.h"

namespace ld {
namespace {

using torch::Tensor;

TEST(Networks, OutputAndGradientsStayFiniteAtEveryExtremeUnderEveryLoss) {
  for (const NetworkConfig& config : every_network()) {
    const auto network = small_network(config, torch::kFloat32);
    for (const float number : extreme_numbers())
      for (const bool in_features : {true, false}) {
        NetworkInput input = random_input(config, 1, 3, 7, 6, torch::kFloat32);
        Tensor& hit = in_features ? input.features : input.radiance;
        hit = sprinkle(hit, number, 70);
        const std::string where =
            title(config) + fmt::format(": {:g} in ", number) + (in_features ? "features" : "radiance");
        for (const std::string& name : loss_names()) {
          const Tensor output = network->forward(input);
          ASSERT_TRUE(all_finite(output)) << where;
          const auto gradients = torch::autograd::grad({make_loss(name)(output, torch::ones_like(output))},
                                                       network->parameters(), {}, /*retain_graph=*/false,
                                                       /*create_graph=*/false, /*allow_unused=*/true);
          for (const Tensor& gradient : gradients)
            if (gradient.defined()) {
              ASSERT_TRUE(all_finite(gradient)) << where << ", loss " << name;
            }
        }
      }
  }
}

TEST(Networks, AConstantStaysForLogitsOfAnySizeAndOneToEightLayers) {
  for (NetworkConfig config : averaging_configs())
    for (const int64_t layers :
         has_layers(config) ? std::vector<int64_t>{1, 2, 5, 8} : std::vector<int64_t>{2})
      for (const double scale : {1.0, 10.0, 100.0, 1e3, 1e4}) {
        config.layers = layers;
        config.kernel_size = 5;
        const auto network = small_network(config, torch::kFloat32);
        scale_logits(*network, scale);
        NetworkInput input = with_one_reflectance(random_input(config, 1, 3, 9, 10, torch::kFloat32), config);
        input.radiance = (input.valid * 0.7F).expand({1, 3, 3, 9, 10}).contiguous();
        const c10::InferenceMode no_graph;
        const double error = (network->forward(input) / 0.7F - 1).abs().max().item<double>();
        EXPECT_LE(error, 1e-5) << title(config) << ", logits times " << scale;
      }
}

/// How far a sample can send its radiance.
int64_t reach(const NetworkConfig& config) {
  const int64_t radius = config.kernel_size / 2;
  if (!network_traits(config.name).has_levels) return radius;
  const int64_t coarsest = int64_t(1) << (config.levels - 1);
  return coarsest * (radius + 2);  // a coarse pixel's own width, and one more for bilinear upscaling
}

TEST(Networks, TheResultLiesWithinTheSamplesInReach) {
  for (const NetworkConfig& config : averaging_configs())
    for (const double scale : {1.0, 30.0}) {
      const auto network = small_network(config, torch::kFloat32);
      scale_logits(*network, scale);
      NetworkInput input = with_one_reflectance(random_input(config, 1, 3, 24, 26, torch::kFloat32), config);
      input.radiance = input.radiance.pow(6);
      const double infinity = std::numeric_limits<double>::infinity();
      const int64_t radius = reach(config), size = 2 * radius + 1;
      const auto padded_max = [&](const Tensor& t) {
        return at::max_pool2d(at::constant_pad_nd(t, {radius, radius, radius, radius}, -infinity), size, 1);
      };
      const Tensor missing = input.valid.eq(0);
      const Tensor high = padded_max(input.radiance.masked_fill(missing, -infinity).amax(1));
      const Tensor low = -padded_max(-input.radiance.masked_fill(missing, infinity).amin(1));
      const c10::InferenceMode no_graph;
      const Tensor output = network->forward(input);
      EXPECT_TRUE(output.ge(low * (1 - 1e-5)).all().item<bool>()) << title(config) << ", " << scale;
      EXPECT_TRUE(output.le(high * (1 + 1e-5)).all().item<bool>()) << title(config) << ", " << scale;
    }
}

// Radiance enters the kernels through the features alone, so with equal features the kernels are fixed.
TEST(Networks, RadianceTimesAPowerOfTwoIsTheResultTimesItBitForBit) {
  for (const NetworkConfig& config : averaging_configs()) {
    const auto network = small_network(config, torch::kFloat32);
    NetworkInput input = random_input(config, 1, 3, 12, 13, torch::kFloat32);
    const c10::InferenceMode no_graph;
    const Tensor before = network->forward(input);
    input.radiance = input.radiance * (1 << 20);
    EXPECT_TRUE(network->forward(input).equal(before * (1 << 20))) << title(config);
  }
}

}  // namespace
}  // namespace ld
