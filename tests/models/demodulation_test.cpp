// Demodulation: what it must not change, where it must be exact, and what it does at the extremes.
#include "models/demodulation.h"

#include <gtest/gtest.h>

#include "tests/models/small_network.h"

namespace ld {
namespace {

using torch::Tensor;

NetworkConfig demodulating(const std::string& name) {
  NetworkConfig config = small_config();
  config.name = name;
  config.features = {"radiance", "albedo", "specular"};
  config.demodulation = "albedo";
  return config;
}

/// The weight of the demodulated picture: 1 or 0 to rounding, everywhere.
void set_beta(Network& network, double logit) {
  const torch::NoGradGuard no_gradient;
  auto parameters = network.named_parameters();
  parameters["modulation.weight.0.weight"].zero_();
  parameters["modulation.weight.0.bias"].fill_(logit);
}

/// Input of reflectance a [B, S, 3, H, W] and this radiance.
NetworkInput surfaces(const Tensor& a, const Tensor& radiance) {
  NetworkInput input;
  input.features = at::cat({radiance.log1p(), a, at::zeros_like(a)}, 2);
  input.radiance = radiance;
  input.valid = torch::ones({a.size(0), a.size(1), 1, a.size(3), a.size(4)}, a.options());
  return input;
}

Tensor random_reflectance(int64_t samples, int64_t h, int64_t w) {
  return random_uniform({1, 1, 3, h, w}, 5, 0.05, 0.9).expand({1, samples, 3, h, w}).contiguous();
}

TEST(Demodulator, IsAlbedoAndSpecularWithinItsRange) {
  const NetworkConfig config = demodulating("layer");
  // Pixels: plain, black, one dark channel, above 1, beyond all bounds, negative.
  const Tensor albedo = torch::tensor({0.5, 0.0, 0.8, 1.5, 6e4, -2.0}, torch::kFloat64).view({1, 1, 1, 1, 6});
  const Tensor specular =
      torch::tensor({0.25, 0.0, 0.0, 0.5, 0.0, 0.0}, torch::kFloat64).view({1, 1, 1, 1, 6});
  Tensor features = at::cat({at::zeros({1, 1, 3, 1, 6}, torch::kFloat64), albedo.repeat({1, 1, 3, 1, 1}),
                             specular.repeat({1, 1, 3, 1, 1})},
                            2);
  features.select(4, 2).narrow(2, 4, 1).zero_();  // its green
  const Tensor a = demodulator(features, config);
  EXPECT_DOUBLE_EQ(a[0][0][0][0][0].item<double>(), 0.75);
  EXPECT_DOUBLE_EQ(a[0][0][0][0][1].item<double>(), 1) << "black keeps its radiance";
  EXPECT_DOUBLE_EQ(a[0][0][1][0][2].item<double>(), 0.02);
  EXPECT_DOUBLE_EQ(a[0][0][0][0][3].item<double>(), 2);
  EXPECT_DOUBLE_EQ(a[0][0][0][0][4].item<double>(), 64);
  EXPECT_DOUBLE_EQ(a[0][0][0][0][5].item<double>(), 1);
}

TEST(Demodulator, NeedsTheAlbedoAlone) {
  NetworkConfig config = demodulating("layer");
  config.features = {"radiance", "albedo"};
  EXPECT_NO_THROW(make_network(config));
  config.features = {"radiance", "specular"};
  EXPECT_THROW(make_network(config), UsageError);
}

TEST(Modulators, AreMeanAndRelativeVarianceOfTheValidSamples) {
  const Tensor a =
      torch::tensor({0.2, 0.6, 9.0}, torch::kFloat64).view({1, 3, 1, 1, 1}).repeat({1, 1, 3, 1, 2});
  Tensor valid = torch::ones({1, 3, 1, 1, 2}, torch::kFloat64);
  valid.select(1, 2).zero_();
  valid.select(4, 1).zero_();  // no sample at all
  const Tensor m = modulators(a, valid);
  EXPECT_NEAR(m[0][0][0][0].item<double>(), 0.4, 1e-12);
  EXPECT_NEAR(m[0][3][0][0].item<double>(), 0.04 / 0.16, 1e-12);
  EXPECT_EQ(m.select(3, 1).abs().max().item<double>(), 0);
}

// Of the same weights, whatever beta: a constant reflectance is divided out and multiplied back.
TEST(Demodulation, ByAConstantChangesNothingButRounding) {
  for (const std::string& name : averaging_networks()) {
    NetworkConfig config = demodulating(name);
    const auto network = small_network(config, torch::kFloat64);
    const Tensor radiance = random_uniform({1, 4, 3, 7, 6}, 3, 0, 5);
    for (const double a : {0.02, 0.3, 1.0, 3.0}) {
      const NetworkInput input = surfaces(at::full_like(radiance, a), radiance);
      set_beta(*network, 1e3);
      const Tensor demodulated = network->forward(input);
      set_beta(*network, -1e3);
      const Tensor plain = network->forward(input);
      EXPECT_LE(((demodulated - plain).abs() / (plain + 1e-3)).max().item<double>(), 1e-12)
          << name << " " << a;
    }
  }
}

TEST(Demodulation, ATextureUnderConstantLightComesOutAsItIs) {
  for (const std::string& name : averaging_networks()) {
    const auto network = small_network(demodulating(name), torch::kFloat32);
    const Tensor a = random_reflectance(4, 9, 7).to(torch::kFloat32);
    const Tensor light = torch::tensor({2.0F, 0.5F, 7.0F}).view({1, 1, 3, 1, 1});
    set_beta(*network, 1e3);
    const Tensor output = network->forward(surfaces(a, a * light));
    const Tensor expected = (a * light).select(1, 0);
    EXPECT_LE(((output - expected).abs() / expected).max().item<double>(), 2e-6) << name;
  }
}

// Mirrors and glass have a specular colour and no albedo; lamps and what lies behind everything neither.
TEST(Demodulation, ALampBesideAWallKeepsItsRadiance) {
  for (const std::string& name : averaging_networks()) {
    const auto network = small_network(demodulating(name), torch::kFloat32);
    Tensor a = torch::full({1, 2, 3, 8, 8}, 0.5F);
    Tensor radiance = torch::full({1, 2, 3, 8, 8}, 0.25F);
    // A pixel half lamp and half wall: one sample each.
    a.narrow(1, 0, 1).narrow(3, 4, 1).narrow(4, 4, 1).zero_();
    radiance.narrow(1, 0, 1).narrow(3, 4, 1).narrow(4, 4, 1).fill_(100);
    for (const double logit : {-1e3, 0.0, 1e3}) {
      set_beta(*network, logit);
      const Tensor output = network->forward(surfaces(a, radiance));
      EXPECT_TRUE(all_finite(output)) << name;
      EXPECT_GE(output.min().item<double>(), 0.25 * (1 - 1e-5)) << name;
      EXPECT_LE(output.max().item<double>(), 100) << name;
    }
  }
}

TEST(Demodulation, HoldsAtTheExtremes) {
  for (const std::string& name : averaging_networks()) {
    const auto network = small_network(demodulating(name), torch::kFloat32);
    set_beta(*network, 0);
    for (const float value : {0.0F, 1e-45F, 1e-38F, 1.0F, 65504.0F, 1e30F, 3e38F})
      for (const float a : {0.0F, 1e-38F, 0.02F, 1.0F, 65504.0F}) {
        const Tensor radiance = torch::full({1, 1, 3, 5, 4}, value);
        const torch::NoGradGuard no_gradient;
        NetworkInput input = surfaces(torch::full_like(radiance, a), radiance);
        input.features.narrow(2, 0, 3).clamp_(0, 100);
        const Tensor output = network->forward(input);
        EXPECT_TRUE(all_finite(output)) << name << " " << value << " on " << a;
        // Denormal numbers may count as 0 on the way.
        EXPECT_LE((output - radiance).abs().max().item<double>(), 1e-5 * value + 1e-38)
            << name << " " << value << " on " << a;
      }
  }
}

TEST(Demodulation, APixelWithoutSamplesReceivesFromItsNeighbours) {
  for (const std::string& name : averaging_networks()) {
    const auto network = small_network(demodulating(name), torch::kFloat32);
    const Tensor radiance = torch::full({1, 2, 3, 6, 6}, 3.0F);
    NetworkInput input = surfaces(torch::full_like(radiance, 0.5F), radiance);
    input.valid.narrow(3, 2, 1).narrow(4, 3, 1).zero_();
    const Tensor output = network->forward(input);
    EXPECT_LE((output - 3).abs().max().item<double>(), 1e-5) << name;
  }
}

TEST(Demodulation, BeginsByTheVarianceOfTheReflectance) {
  const auto network = make_network(demodulating("layer"));
  initialise(*network, 1);
  auto parameters = network->named_parameters();
  const Tensor weight = parameters["modulation.weight.0.weight"];
  EXPECT_FLOAT_EQ(weight[0][0].item<float>(), 4);
  EXPECT_EQ(weight.narrow(1, 1, weight.size(1) - 1).abs().max().item<double>(), 0);
}

}  // namespace
}  // namespace ld
