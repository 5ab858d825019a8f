// Super-resolution and denoiser in two stages: what its parts are, and what goes from one to the other.
#include <gtest/gtest.h>

#include <cmath>

#include "losses/loss.h"
#include "models/light_kpcn.h"
#include "models/super_resolution.h"
#include "ops/tone_map_tensor.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"
#include "tests/support/gradient_check.h"

namespace ld {
namespace {

using torch::Tensor;

NetworkConfig two_stages(std::vector<std::string> features = {"radiance", "normal", "depth"}) {
  NetworkConfig config = small_config();
  config.name = "espcn_kpcn";
  config.features = std::move(features);
  return config;
}

int64_t parameter_count(const torch::nn::Module& module) {
  int64_t count = 0;
  for (const Tensor& parameter : module.parameters()) count += parameter.numel();
  return count;
}

void fill(torch::nn::Module& module, const std::string& name, double value) {
  const torch::NoGradGuard no_gradient;
  auto named = module.named_parameters();
  named[name].fill_(value);
}

/// All pixels keep their own colour.
void make_identity(torch::nn::Module& denoiser) {
  const torch::NoGradGuard no_gradient;
  auto named = denoiser.named_parameters();
  named["2.weight"].zero_();
  Tensor bias = named["2.bias"];
  bias.zero_();
  bias[bias.numel() / 2] = 300;
}

TEST(SpaceToDepth, FollowsItsFormulaAndIsUndone) {
  const Tensor x = random_normal({2, 3, 6, 8}, 1), deep = space_to_depth(x);
  ASSERT_EQ(deep.sizes(), (std::vector<int64_t>{2, 12, 3, 4}));
  for (int64_t c = 0; c < 3; ++c)
    for (int64_t i = 0; i < 2; ++i)
      for (int64_t j = 0; j < 2; ++j)
        for (int64_t y = 0; y < 3; ++y)
          for (int64_t k = 0; k < 4; ++k)
            ASSERT_EQ(deep[1][c * 4 + 2 * i + j][y][k].item<double>(),
                      x[1][c][2 * y + i][2 * k + j].item<double>());
  EXPECT_TRUE(depth_to_space(deep).equal(x));
  EXPECT_TRUE(space_to_depth(depth_to_space(deep)).equal(deep));
  EXPECT_TRUE(depth_to_space(deep).equal(at::pixel_shuffle(deep, 2)));
}

TEST(SpaceToDepth, RepeatsTheBorderOfOddSides) {
  const Tensor x = random_normal({1, 2, 5, 3}, 2), deep = space_to_depth(x);
  ASSERT_EQ(deep.sizes(), (std::vector<int64_t>{1, 8, 3, 2}));
  EXPECT_TRUE(depth_to_space(deep).narrow(2, 0, 5).narrow(3, 0, 3).equal(x));
  EXPECT_EQ(deep[0][7][2][1].item<double>(), x[0][1][4][2].item<double>());
}

// Of 11 channels of guides: position, normal, albedo, index of refraction, roughness.
TEST(EspcnKpcn, HasTheParametersOfItsSizes) {
  SuperResolutionConfig published;
  EXPECT_EQ(parameter_count(SuperResolution(3 + 4 * 11, published)), 97196);
  published.convolutions = {32, 16};
  EXPECT_EQ(parameter_count(SuperResolution(3 + 4 * 11, published)), 43996);
  EXPECT_EQ(parameter_count(LightKpcn(11, 32, 3)), 15913);
  EXPECT_EQ(parameter_count(LightKpcn(11, 64, 3)), 50249);
}

TEST(EspcnKpcn, BilinearWeightsMakeABilinearPictureOfARamp) {
  SuperResolutionConfig config;
  config.convolutions = {3, 3};
  config.activation = "relu";
  SuperResolution network(3, config);
  network.to(torch::kFloat64);
  auto named = network.named_parameters();
  const torch::NoGradGuard no_gradient;
  for (int64_t c = 0; c < 3; ++c) {
    named["0.weight"][c][c][2][2] = 1;
    named["1.weight"][c][c][1][1] = 1;
    for (int64_t i = 0; i < 2; ++i)
      for (int64_t j = 0; j < 2; ++j) {
        Tensor taps = named["2.weight"][4 * c + 2 * i + j][c];
        for (const auto& [y, wy] : {std::pair<int64_t, double>{1, 0.75}, {i == 0 ? 0 : 2, 0.25}})
          for (const auto& [x, wx] : {std::pair<int64_t, double>{1, 0.75}, {j == 0 ? 0 : 2, 0.25}})
            taps[y][x] = wy * wx;
      }
  }
  const Tensor y = torch::arange(5, torch::kFloat64).view({1, 1, 5, 1}),
               x = torch::arange(7, torch::kFloat64).view({1, 1, 1, 7});
  const Tensor ramp = at::cat({1 + x + 2 * y, 3 + 0.5 * x - 0.25 * y, 9 - x + 0 * y}, 1);
  EXPECT_LE(largest_difference(network.forward(ramp),
                               at::upsample_bilinear2d(ramp, {10, 14}, /*align_corners=*/false)),
            1e-12);
}

TEST(EspcnKpcn, BeginsWithoutACheckerboard) {
  NetworkConfig config = two_stages();
  const auto network = make_network(config);
  initialise(*network, 5);
  NetworkInput input = random_input(config, 1, 2, 10, 12, torch::kFloat32);
  input.valid.fill_(1);
  const Tensor first = network->stages(input, SecondReads::first).first;
  for (const auto& [i, j] : {std::pair(0, 1), std::pair(1, 0), std::pair(1, 1)})
    EXPECT_LE(largest_difference(first.slice(2, i, 10, 2).slice(3, j, 12, 2),
                                 first.slice(2, 0, 10, 2).slice(3, 0, 12, 2)),
              1e-6);
  EXPECT_GT(first.max().item<float>(), 0);
}

TEST(LightKpcn, IsAWeightedMeanOfNinePixels) {
  LightKpcn denoiser(4, 8, 3);
  denoiser.to(torch::kFloat64);
  {
    const torch::NoGradGuard no_gradient;
    uint32_t seed = 20;
    for (Tensor parameter : denoiser.parameters())
      parameter.copy_(random_normal(parameter.sizes(), ++seed, 0.7));
  }
  const Tensor colours = random_normal({2, 3, 9, 11}, 3), guides = random_normal({2, 4, 9, 11}, 4),
               known = torch::zeros({2, 9, 11}, torch::kFloat64);
  const Tensor filtered = denoiser.forward(colours, guides, known);
  const double infinity = std::numeric_limits<double>::infinity();
  const auto highest = [&](const Tensor& x) {
    return at::max_pool2d(at::constant_pad_nd(x, {1, 1, 1, 1}, -infinity), 3, 1);
  };
  EXPECT_TRUE(filtered.le(highest(colours) + 1e-12).all().item<bool>());
  EXPECT_TRUE(filtered.ge(-highest(-colours) - 1e-12).all().item<bool>());
  // Weights sum to 1 at the border, too: a constant beside any kernels stays.
  const Tensor logits = denoiser.logits(colours, guides);
  EXPECT_LE((at::softmax(logits, 1).sum(1) - 1).abs().max().item<double>(), 1e-12);
  const Tensor ones = torch::ones_like(colours);
  EXPECT_LE((denoiser.forward(ones, guides, known) - 1).abs().max().item<double>(), 1e-12);
}

TEST(EspcnKpcn, AnIdentityKernelLeavesTheFirstStage) {
  for (const NetworkConfig& config : {two_stages(), two_stages({"radiance", "albedo", "depth"})}) {
    const auto network = small_network(config, torch::kFloat32);
    make_identity(*network->named_children()["denoiser"]);
    NetworkInput input = random_input(config, 2, 3, 7, 9, torch::kFloat32);
    input.valid.select(1, 0).fill_(1);
    const Stages made = network->stages(input, SecondReads::first);
    EXPECT_TRUE(made.picture.equal(made.first));
    EXPECT_TRUE(network->forward(input).equal(made.picture));
  }
}

TEST(EspcnKpcn, TheSecondStageReadsWhatItIsToldTo) {
  NetworkConfig config = two_stages({"radiance", "albedo", "depth"});
  config.demodulation = "albedo";
  const auto network = small_network(config, torch::kFloat64);
  NetworkInput input = random_input(config, 1, 3, 6, 8, torch::kFloat64);
  input.valid.fill_(1);
  const Stages own = network->stages(input, SecondReads::first);
  expect_near(network->stages(input, SecondReads::first_stopped).picture, own.picture, 1e-12);
  expect_near(network->stages(input, SecondReads::given, own.first).picture, own.picture, 1e-9);
  const Tensor other = random_uniform({1, 3, 6, 8}, 9, 0, 2);
  EXPECT_GT(largest_difference(network->stages(input, SecondReads::given, other).picture, own.picture), 1e-3);
}

/// Of the loss of the picture, with respect to the first stage's parameters.
double first_stage_gradient(Network& network, const NetworkInput& input, SecondReads reads) {
  const Tensor picture = network.stages(input, reads, torch::ones({2, 3, 8, 6}, torch::kFloat64)).picture;
  network.zero_grad();
  make_loss("l2_tonemapped")(picture, torch::full_like(picture, 0.3)).backward();
  double sum = 0;
  for (const auto& entry : network.named_parameters())
    if (entry.key().rfind("super_resolution", 0) == 0 && entry.value().grad().defined())
      sum += entry.value().grad().abs().sum().item<double>();
  return sum;
}

TEST(EspcnKpcn, GradientsReachTheFirstStageEndToEndAlone) {
  const NetworkConfig config = two_stages();
  const auto network = small_network(config, torch::kFloat64);
  const NetworkInput input = random_input(config, 2, 3, 8, 6, torch::kFloat64);
  EXPECT_EQ(first_stage_gradient(*network, input, SecondReads::first_stopped), 0);
  EXPECT_EQ(first_stage_gradient(*network, input, SecondReads::given), 0);
  EXPECT_GT(first_stage_gradient(*network, input, SecondReads::first), 0);
}

TEST(EspcnKpcn, BothStagesHaveTheGradientsOfFiniteDifferences) {
  for (const char* reads : {"light", "guides", "both"})
    for (const char* activation : {"tanh", "relu"}) {
      NetworkConfig config = two_stages({"radiance", "albedo", "normal"});
      config.super_resolution.reads = reads;
      config.super_resolution.activation = activation;
      config.demodulation = "albedo";
      const auto network = small_network(config, torch::kFloat64);
      const NetworkInput input = random_input(config, 1, 2, 5, 7, torch::kFloat64);
      const Tensor target = random_uniform({1, 3, 5, 7}, 8, 0, 3);
      const Loss loss = make_loss("l2_tonemapped");
      expect_gradients(
          [&](const std::vector<Tensor>&) {
            const Stages made = network->stages(input, SecondReads::first);
            return loss(made.picture, target) + 0.7 * loss(made.first, target);
          },
          network->parameters(), 6);
    }
}

// Blocks of 2x2 pixels of one radiance are a picture of half the resolution.
TEST(EspcnKpcn, LightAtHalfResolutionIsTheMeanOfFourPixels) {
  for (const bool demodulates : {false, true})
    for (const auto& [h, w] : {std::pair<int64_t, int64_t>{6, 8}, {7, 5}, {1, 1}, {2, 3}}) {
      NetworkConfig made = two_stages({"normal", "radiance", "albedo"}),
                    given = two_stages({"normal", "half_radiance", "albedo"});
      if (demodulates) made.demodulation = given.demodulation = "albedo";
      NetworkInput input = random_input(made, 1, 2, h, w, torch::kFloat64);
      input.valid.fill_(1);
      const Tensor half = random_uniform({1, 2, 3, (h + 1) / 2, (w + 1) / 2}, 3, 0, 3);
      input.radiance = half.repeat_interleave(2, 3).repeat_interleave(2, 4).narrow(3, 0, h).narrow(4, 0, w);
      input.radiance = input.radiance.mean(1, true).expand({1, 2, 3, h, w}).contiguous();
      NetworkInput other = input;
      other.features = input.features.clone();
      other.features.narrow(2, 3, 3).copy_(tone_map(input.radiance));
      other.radiance = torch::rand_like(input.radiance);  // of other random numbers: not read
      EXPECT_LE(largest_difference(small_network(given, torch::kFloat64)->forward(other),
                                   small_network(made, torch::kFloat64)->forward(input)),
                1e-9)
          << h << "x" << w << (demodulates ? ", demodulating" : "");
    }
}

TEST(EspcnKpcn, ATextureComesBackAfterDemodulation) {
  NetworkConfig config = two_stages({"radiance", "albedo"});
  config.demodulation = "albedo";
  const auto network = small_network(config, torch::kFloat64);
  // The same light everywhere, whatever is read.
  fill(*network, "super_resolution.2.weight", 0);
  fill(*network, "super_resolution.2.bias", 0.9);
  NetworkInput input = random_input(config, 1, 2, 6, 7, torch::kFloat64);
  input.valid.fill_(1);
  const Tensor albedo = random_uniform({1, 1, 3, 6, 7}, 4, 0.1, 0.9);
  input.features.narrow(2, 3, 3).copy_(albedo.expand({1, 2, 3, 6, 7}));
  const Tensor light = tone_map_inverse(torch::full({1}, 0.9, torch::kFloat64));
  expect_near(network->forward(input), albedo.select(1, 0) * light, 1e-12);
}

TEST(EspcnKpcn, WhatDoesNotFitIsNamed) {
  EXPECT_ERROR(make_network(two_stages({"normal", "depth"})), "either 'half_radiance'");
  EXPECT_ERROR(make_network(two_stages({"radiance", "half_radiance", "depth"})), "name one of the two");
  EXPECT_ERROR(make_network(two_stages({"radiance"})), "has light alone");
  NetworkConfig config = two_stages();
  config.exposure_normalisation = true;
  EXPECT_ERROR(make_network(config), "exposure_normalisation");
  config = small_config();
  config.features.emplace_back("half_radiance");
  EXPECT_ERROR(make_network(config), "reads light at full resolution");
  const NetworkConfig one = small_config();
  EXPECT_ERROR(small_network(one, torch::kFloat32)
                   ->stages(random_input(one, 1, 1, 4, 4, torch::kFloat32), SecondReads::first),
               "has one stage");
}

TEST(ToneMapInverse, UndoesTheToneMapAndPullsBackFromBeyond) {
  const Tensor x = torch::tensor({0.0, 1e-45, 1e-30, 1e-5, 0.003, 0.5, 1.0, 77.0, 65504.0}, torch::kFloat64);
  EXPECT_LE(
      ((tone_map_inverse(tone_map(x)) - x) / x.clamp_min(1e-300)).abs().narrow(0, 1, 8).max().item<double>(),
      1e-12);
  for (const double beyond : {-1e30, -1.0, 1e30, std::numeric_limits<double>::infinity()}) {
    const Tensor mapped = torch::full({1}, beyond, torch::kFloat64).requires_grad_();
    const Tensor linear = tone_map_inverse(mapped);
    EXPECT_EQ(linear.item<double>(), beyond < 0 ? 0 : 65504);
    linear.backward();
    EXPECT_GT(mapped.grad().item<double>(), 0);
    EXPECT_TRUE(std::isfinite(mapped.grad().item<double>()));
  }
  expect_gradients([](const auto& v) { return tone_map_inverse(v[0]); },
                   {variable(random_uniform({40}, 5, 0.05, 2.7))});
}

}  // namespace
}  // namespace ld
