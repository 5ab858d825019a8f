// Exposure normalisation: what a network is told of the brightness of a picture, and that the result follows
// it.
#include "models/exposure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ops/tone_map_tensor.h"
#include "tests/models/small_network.h"

namespace ld {
namespace {

using torch::Tensor;

Tensor all_valid(const Tensor& radiance) {
  return torch::ones({radiance.size(0), radiance.size(1), 1, radiance.size(3), radiance.size(4)},
                     radiance.options());
}

/// Radiance of [2, 3, 3, 16, 17], half of the samples black as path tracers leave them.
Tensor some_radiance() {
  const Tensor radiance = random_uniform({2, 3, 3, 16, 17}, 5, 0, 4).to(torch::kFloat32);
  return radiance * random_uniform({2, 3, 1, 16, 17}, 6, 0, 1).gt(0.5);
}

NetworkConfig exposed(NetworkConfig config) {
  config.exposure_normalisation = true;
  return config;
}

TEST(Exposure, MakesAConstantPictureMiddleGrey) {
  const Tensor radiance = torch::full({1, 2, 3, 4, 5}, 37.0F);
  EXPECT_NEAR(exposure_of(radiance, all_valid(radiance))[0].item<double>(), 0.18 / 37, 1e-12);
  NetworkInput input = random_input(small_config(), 1, 2, 4, 5, torch::kFloat32);
  input.radiance = radiance * input.valid;
  const Tensor before = input.features;
  const NetworkInput seen = with_exposure(input, exposure_of(input.radiance, input.valid), small_config());
  const Tensor grey = tone_map(torch::full({1, 2, 3, 4, 5}, 0.18F)) * input.valid;
  EXPECT_LE((seen.features.narrow(2, 0, 3) - grey).abs().max().item<double>(), 1e-6);
  EXPECT_TRUE(seen.features.narrow(2, 3, 4).equal(before.narrow(2, 3, 4)));
  EXPECT_TRUE(seen.radiance.equal(input.radiance)) << "kernels act on the radiance as it is";
}

TEST(Exposure, FollowsAPowerOfTwoBitForBitAndAnyFactorToRounding) {
  const Tensor radiance = some_radiance(), valid = all_valid(radiance);
  const Tensor exposure = exposure_of(radiance, valid);
  for (const int power : {-90, -20, -1, 1, 7, 100}) {
    const Tensor scaled = exposure_of(radiance * std::ldexp(1.0F, power), valid);
    EXPECT_TRUE((scaled * std::ldexp(1.0, power)).equal(exposure)) << power;
  }
  for (const double factor : {1e-20, 0.3, 683.0, 1e25}) {
    const Tensor scaled = exposure_of((radiance.to(torch::kFloat64) * factor), valid);
    EXPECT_LE(((scaled * factor - exposure) / exposure).abs().max().item<double>(), 1e-12) << factor;
  }
}

TEST(Exposure, IsNotDecidedByAFireflyNorByDarkness) {
  Tensor radiance = some_radiance();
  const Tensor valid = all_valid(radiance), exposure = exposure_of(radiance, valid);
  radiance.index_put_({0, 1, torch::indexing::Slice(), 3, 4}, 3e38);
  double ratio = (exposure_of(radiance, valid) / exposure)[0].item<double>();
  EXPECT_GT(ratio, 0.6);  // some 130 powers of two over 272 pixels: 2^(-130 / 272)
  EXPECT_LT(ratio, 1);
  // Black pixels, bad samples and samples that are not valid have no say at all.
  radiance = some_radiance();
  const Tensor black = at::cat({radiance, torch::zeros_like(radiance)}, 3);
  EXPECT_TRUE(exposure_of(black, all_valid(black)).equal(exposure));
  const Tensor bad = at::cat({radiance, torch::full_like(radiance, std::nanf(""))}, 1);
  EXPECT_TRUE(exposure_of(bad, all_valid(bad)).equal(exposure));
  const Tensor masked = at::cat({radiance, radiance + 5}, 1),
               mask = at::cat({valid, torch::zeros_like(valid)}, 1);
  EXPECT_TRUE(exposure_of(masked, mask).equal(exposure));
}

TEST(Exposure, StaysFiniteAtTheEndsOfTheRange) {
  for (const float value : {0.0F, 1e-45F, 1e-38F, 3e38F}) {
    NetworkConfig config = exposed(small_config());
    const auto network = small_network(config, torch::kFloat32);
    NetworkInput input = random_input(config, 1, 2, 6, 7, torch::kFloat32);
    input.radiance = torch::full_like(input.radiance, value) * input.valid;
    const Tensor exposure = exposure_of(input.radiance, input.valid);
    EXPECT_TRUE(std::isfinite(exposure[0].item<double>()) && exposure[0].item<double>() > 0) << value;
    const torch::NoGradGuard no_graph;
    const Tensor output = network->forward(input);
    EXPECT_TRUE(output.isfinite().all().item<bool>()) << value;
    EXPECT_LE((output / (value > 1e-30F ? value : 1) - (value > 1e-30F ? 1 : 0)).abs().max().item<double>(),
              1e-5)
        << value;
  }
}

TEST(Exposure, MakesEveryNetworkEquivariant) {
  for (const NetworkConfig& given : averaging_configs()) {
    const NetworkConfig config = exposed(given);
    const auto network = small_network(config, torch::kFloat32);
    const NetworkInput input = random_input(config, 2, 3, 19, 13, torch::kFloat32);
    const torch::NoGradGuard no_graph;
    const Tensor output = network->forward(input);
    for (const int power : {-40, -3, 20, 60}) {
      NetworkInput scaled = input;
      scaled.radiance = input.radiance * std::ldexp(1.0F, power);
      EXPECT_TRUE((network->forward(scaled) * std::ldexp(1.0F, -power)).equal(output))
          << title(config) << " 2^" << power;
    }
    NetworkInput scaled = input;
    scaled.radiance = input.radiance * 683.0F;
    EXPECT_LE((network->forward(scaled) / 683 - output).abs().max().item<double>(), 2e-5 * 4)
        << title(config);
    // And it does see the radiance: another picture in the same place gives other kernels.
    const auto plain = small_network(given, torch::kFloat32);
    EXPECT_FALSE(plain->forward(input).equal(output)) << title(config);
  }
}

TEST(Exposure, LeavesANetworkWithoutTheFeatureAlone) {
  NetworkConfig config = small_config();
  config.features = {"normal", "depth"};
  const NetworkInput input = random_input(config, 1, 3, 8, 9, torch::kFloat32);
  const Tensor plain = small_network(config, torch::kFloat32)->forward(input);
  EXPECT_TRUE(small_network(exposed(config), torch::kFloat32)->forward(input).equal(plain));
}

}  // namespace
}  // namespace ld
