// The recurrent autoencoder: against the table of its paper, against numbers by hand, at all sizes, over long
// sequences, and the gradient through time.
#include "models/recurrent.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/tone_map.h"
#include "models/graphs/network_cost.h"
#include "models/network_numbers.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"
#include "tests/support/gradient_check.h"

namespace ld {
namespace {

using torch::Tensor;

/// Figure 4 of Chaitanya et al. 2017, the column AE.
NetworkConfig published_recurrent() {
  NetworkConfig config;
  config.name = "recurrent";
  config.unet.encoder = {{32, 32}, {43}, {57}, {76}, {101}};
  config.unet.bottleneck = {101};
  config.unet.decoder = {{76, 76}, {57, 57}, {43, 43}, {32, 32}, {128, 64}};
  config.unet.upsampling = "nearest";
  config.initialisation = "he";
  return config;
}

/// Of frame `f` of a sequence of small_recurrent_config(): encoded features as they are, a few rays escaped.
NetworkInput recurrent_input(uint32_t f, torch::ScalarType type, int64_t b = 1, int64_t h = 6, int64_t w = 7,
                             int64_t s = 2) {
  const NetworkConfig config = small_recurrent_config();
  NetworkInput input = random_input(config, b, s, h, w, torch::kFloat64, 100 + 10 * f);
  const auto set = [&](const char* name, const Tensor& values) {
    const Tensor of_samples = values * input.valid;
    input.features.narrow(2, first_channel(config.features, name), values.size(2)) = of_samples;
  };
  const Tensor escaped = random_uniform({b, s, 1, h, w}, 200 + f).gt(0.9);
  set("depth", random_uniform({b, s, 1, h, w}, 300 + f, 0.2, 0.8).masked_fill(escaped, 1));
  set("albedo", random_uniform({b, s, 3, h, w}, 400 + f, 0.1, 0.8).masked_fill(escaped, 0));
  set("specular", random_uniform({b, s, 3, h, w}, 500 + f, 0, 0.2).masked_fill(escaped, 0));
  set("emission", random_uniform({b, s, 3, h, w}, 600 + f, 0, 0.1));
  return to_type(input, type);
}

TEST(Recurrent, HasTheConvolutionsOfThePaperAndThoseAlone) {
  const auto network = make_network(published_recurrent());
  std::map<std::string, std::pair<int64_t, int64_t>> expected;  // outputs, inputs
  const std::vector<int64_t> width = {32, 43, 57, 76, 101, 101};
  const auto add = [&](const std::string& name, int64_t inputs, int64_t outputs) {
    expected["autoencoder." + name] = {outputs, inputs};
  };
  add("encoder0.0", 7, 32);
  add("encoder0.1", 32, 32);
  for (size_t level = 0; level < 6; ++level) {
    if (level > 0) add("encoder" + std::to_string(level) + ".0", width[level - 1], width[level]);
    const std::string block = "recurrent" + std::to_string(level);
    add(block + ".input.0", width[level], width[level]);
    add(block + ".joint.0", 2 * width[level], width[level]);
    add(block + ".joint.1", width[level], width[level]);
  }
  const int64_t decoder[5][3] = {{202, 76, 76}, {152, 57, 57}, {114, 43, 43}, {86, 32, 32}, {64, 128, 64}};
  for (int64_t block = 0; block < 5; ++block)
    for (int64_t i = 0; i < 2; ++i)
      add("decoder" + std::to_string(block) + "." + std::to_string(i), decoder[block][i],
          decoder[block][i + 1]);
  add("output", 64, 3);
  EXPECT_EQ(expected.size(), 36U);

  int64_t parameters = 0;
  size_t convolutions = 0;
  for (const auto& parameter : network->named_parameters()) {
    parameters += parameter.value().numel();
    if (parameter.value().dim() == 1) continue;
    ++convolutions;
    const std::string name =
        parameter.key().substr(0, parameter.key().size() - std::string(".weight").size());
    ASSERT_EQ(expected.count(name), 1U) << name;
    EXPECT_EQ(parameter.value().sizes(),
              (std::vector<int64_t>{expected[name].first, expected[name].second, 3, 3}))
        << name;
  }
  EXPECT_EQ(convolutions, 36U);
  EXPECT_EQ(parameters, 1951935);
  // 246,000 multiply-adds a pixel.
  EXPECT_NEAR(multiply_adds(published_recurrent(), 1, 128, 128).total() / (128 * 128), 246e3, 500);
}

// Of one pixel the centres of the kernels count alone.
TEST(Recurrent, BlockAgreesWithNumbersByHand) {
  RecurrentBlock block(1);
  const torch::NoGradGuard no_gradient;
  block.to(torch::kFloat64);
  auto named = block.named_parameters();
  for (auto& parameter : named) parameter.value().fill_(parameter.value().dim() == 1 ? 0.25 : 7);
  const auto centre = [&](const char* name, int64_t input, double value) {
    named[name][0][input][1][1] = value;
  };
  centre("input.0.weight", 0, 2);
  centre("joint.0.weight", 0, -1);
  centre("joint.0.weight", 1, 3);
  centre("joint.1.weight", 0, 0.5);
  const auto pixel = [](double value) { return torch::full({1, 1, 1, 1}, value, torch::kFloat64); };
  // u = 2 * 1 + 0.25 = 2.25; r = -2.25 + 0.25 = -2, times 0.1; h = 0.5 * -0.2 + 0.25 = 0.15.
  const Tensor first = block.forward(pixel(1), Tensor());
  EXPECT_NEAR(first.item<double>(), 0.15, 1e-15);
  EXPECT_TRUE(block.forward(pixel(1), pixel(0)).equal(first));
  // u = 2 * -3 + 0.25 = -5.75, times 0.1; r = 0.575 + 3 * 0.15 + 0.25 = 1.275; h = 0.6375 + 0.25.
  EXPECT_NEAR(block.forward(pixel(-3), first).item<double>(), 0.8875, 1e-15);
  // A state beyond 65504 counts as that.
  EXPECT_TRUE(block.forward(pixel(1), pixel(1e30)).equal(block.forward(pixel(1), pixel(65504))));
}

TEST(Recurrent, SeesTheLightWithoutTextureAndEmission) {
  NetworkConfig config = small_recurrent_config();
  // One pixel: a surface that emits, a ray that escaped, and a sample that was not drawn.
  NetworkInput input = {torch::zeros({1, 3, channel_count(config.features), 1, 1}, torch::kFloat64),
                        torch::zeros({1, 3, 3, 1, 1}, torch::kFloat64),
                        torch::zeros({1, 3, 1, 1, 1}, torch::kFloat64)};
  const auto set = [&](int64_t sample, const char* name, std::vector<double> values) {
    const int64_t first = first_channel(config.features, name);
    for (size_t c = 0; c < values.size(); ++c) input.features[0][sample][first + int64_t(c)] = values[c];
  };
  input.valid[0][0] = 1;
  input.valid[0][1] = 1;
  input.radiance[0][0].fill_(5);
  input.radiance[0][1].fill_(2);
  input.radiance[0][2].fill_(1000);
  set(0, "normal", {0.5, -0.25, 0.8});
  set(0, "depth", {0.5});
  set(0, "roughness", {0.6});
  set(0, "albedo", {0.4, 0, 0.4});
  set(0, "specular", {0.2, 0, 0});
  set(0, "emission", {tone_map(3.0), tone_map(9.0), 0});
  set(1, "depth", {1});
  set(1, "emission", {tone_map(7.0), 0, 0});  // what escaped counts as its radiance
  const RecurrentInput light(input, config);
  const double emission[3] = {2.5, 5.5, 1}, texture[3] = {0.3, 1e-3, 0.2},
               seen[4] = {0.25, -0.125, 0.75, 0.3};
  for (int64_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(light.emission[0][c].item<double>(), emission[c], 1e-12) << c;
    EXPECT_NEAR(light.texture[0][c].item<double>(), std::pow(texture[c], 0.2), 1e-12) << c;
    const double s = std::max(3.5 - emission[c] * (1 + 1.0 / 2048), 0.0) / texture[c];
    EXPECT_NEAR(light.seen[0][c].item<double>(), std::pow(s, 0.2), 1e-12) << c;
  }
  for (int64_t c = 0; c < 4; ++c) EXPECT_NEAR(light.seen[0][3 + c].item<double>(), seen[c], 1e-12) << c;
  // And back: the radiance where it is above what is emitted, else that.
  const Tensor back = light.picture(light.seen.narrow(1, 0, 3));
  for (int64_t c = 0; c < 3; ++c)
    EXPECT_NEAR(back[0][c].item<double>(), std::max(3.5 - emission[c] / 2048, emission[c]), 1e-12) << c;
  const Tensor reference = torch::full({1, 3, 1, 1}, 8, torch::kFloat64);
  EXPECT_LE((light.picture(light.root(reference)) + light.emission / 2048 - 8).abs().max().item<double>(),
            1e-12);
  EXPECT_TRUE(light.picture(torch::full({1, 3, 1, 1}, -4, torch::kFloat64)).equal(light.emission));
}

// Its emission comes back from the encoding with an error, whose fifth root would be large.
TEST(Recurrent, ALampHasNoLightBesideItsEmission) {
  const NetworkConfig config = small_recurrent_config();
  for (const double value : {1e-38, 1e-3, 1.0, 0.3, 800.0, 65504.0}) {
    NetworkInput input = to_type(recurrent_input(0, torch::kFloat32), torch::kFloat32);
    input.valid.fill_(1);
    input.radiance.fill_(value);
    input.features.narrow(2, first_channel(config.features, "emission"), 3).fill_(tone_map(value));
    const RecurrentInput light(input, config);
    EXPECT_EQ(light.seen.narrow(1, 0, 3).abs().max().item<float>(), 0) << value;
    EXPECT_LE((light.picture(light.seen.narrow(1, 0, 3)) / value - 1).abs().max().item<double>(), 1e-3)
        << value;
  }
}

TEST(Recurrent, PicturesStayFiniteAtTheExtremes) {
  const NetworkConfig config = small_recurrent_config();
  for (const float value : {0.0F, 1e-45F, 1e-38F, 1.0F, 65504.0F, 3e38F})
    for (const float albedo : {0.0F, 1e-38F, 1.0F, 65504.0F})
      for (const float predicted : {-3e38F, 0.0F, 1e-45F, 1.0F, 65504.0F, 3e38F}) {
        NetworkInput input = to_type(recurrent_input(0, torch::kFloat32), torch::kFloat32);
        input.radiance.fill_(value);
        input.features.narrow(2, first_channel(config.features, "albedo"), 3).fill_(albedo);
        const RecurrentInput light(input, config);
        EXPECT_TRUE(all_finite(light.seen)) << value << " " << albedo;
        EXPECT_TRUE(all_finite(light.root(torch::full({1, 3, 6, 7}, value)))) << value << " " << albedo;
        const Tensor p = torch::full({1, 3, 6, 7}, predicted).set_requires_grad(true);
        const Tensor picture = light.picture(p);
        EXPECT_TRUE(all_finite(picture)) << value << " " << albedo << " " << predicted;
        EXPECT_GE(picture.min().item<float>(), 0);
        (picture * 1e-30).sum().backward();
        EXPECT_TRUE(all_finite(p.grad())) << value << " " << albedo << " " << predicted;
      }
}

TEST(Recurrent, BeginsAnewWithoutItsState) {
  for (const torch::ScalarType type : {torch::kFloat32, torch::kFloat64}) {
    const auto network = small_network(small_recurrent_config(), type);
    const torch::NoGradGuard no_gradient;
    NetworkState state, again;
    const NetworkInput first = recurrent_input(0, type), second = recurrent_input(1, type);
    network->forward(first, state);
    EXPECT_EQ(state.size(), 3U);
    const Tensor behind = network->forward(second, state), alone = network->forward(second);
    EXPECT_FALSE(behind.equal(alone));
    EXPECT_TRUE(network->forward(second, again).equal(alone));
    for (auto& [name, tensor] : again) tensor = torch::zeros_like(tensor);
    EXPECT_TRUE(network->forward(second, again).equal(alone)) << "zeros are as good as nothing";
    NetworkConfig forgetful = small_recurrent_config();
    forgetful.recurrence = false;
    const auto without = small_network(forgetful, type);
    NetworkState none;
    without->forward(first, none);
    EXPECT_TRUE(none.empty());
    EXPECT_TRUE(without->forward(second, none).equal(alone));
  }
}

TEST(Recurrent, TakesEverySize) {
  const auto network = small_network(small_recurrent_config(), torch::kFloat32);
  const torch::NoGradGuard no_gradient;
  for (const auto& [h, w] : {std::pair(1, 1), std::pair(3, 20), std::pair(33, 31), std::pair(5, 1)}) {
    NetworkState state, padded_state;
    for (uint32_t f = 0; f < 2; ++f) {
      const NetworkInput input = recurrent_input(f, torch::kFloat32, 2, h, w);
      const Tensor picture = network->forward(input, state);
      ASSERT_EQ(picture.sizes(), (std::vector<int64_t>{2, 3, h, w}));
      // The last row and column repeated by hand, to a multiple of four.
      const int64_t right = (4 - w % 4) % 4, below = (4 - h % 4) % 4;
      const auto repeated = [&](const Tensor& t) {
        return at::replication_pad2d(t.flatten(0, 1), {0, right, 0, below})
            .unflatten(0, {t.size(0), t.size(1)});
      };
      const NetworkInput padded = {repeated(input.features), repeated(input.radiance), repeated(input.valid)};
      // Powers of the last few numbers of a tensor may round otherwise.
      const Tensor cropped = network->forward(padded, padded_state).narrow(2, 0, h).narrow(3, 0, w);
      EXPECT_LE((cropped - picture).abs().max().item<double>(), 1e-5 * picture.max().item<double>());
    }
  }
}

// With weights of any size, however long the sequence is.
TEST(Recurrent, NoSequenceDiverges) {
  for (const double scale : {1.0, 3.0}) {
    const auto network = small_network(small_recurrent_config(), torch::kFloat32);
    const torch::NoGradGuard no_gradient;
    for (Tensor& parameter : network->parameters()) parameter.mul_(scale);
    NetworkState state;
    for (uint32_t f = 0; f < 300; ++f) {
      const Tensor picture = network->forward(recurrent_input(f % 3, torch::kFloat32), state);
      ASSERT_TRUE(all_finite(picture)) << scale << " frame " << f;
    }
  }
}

TEST(Recurrent, IsComparedInFifthRootsOfLight) {
  const auto network = small_network(small_recurrent_config(), torch::kFloat64);
  const NetworkInput input = recurrent_input(0, torch::kFloat64);
  const Tensor reference = random_uniform({1, 3, 6, 7}, 5, 0, 4);
  NetworkState state, same;
  const Compared compared = network->compare(input, reference, state);
  EXPECT_TRUE(compared.picture.equal(network->forward(input, same)));
  InputFaults faults;
  const RecurrentInput light(sanitise(input, faults), small_recurrent_config());
  EXPECT_TRUE(compared.target.equal(light.root(reference)));
  EXPECT_TRUE(light.picture(compared.predicted).equal(compared.picture));
  EXPECT_TRUE(compared.predicted.requires_grad());
  EXPECT_FALSE(compared.target.requires_grad());
  EXPECT_LT(compared.predicted.min().item<double>(), 0) << "what is below 0 has a gradient, too";
}

TEST(Recurrent, GradientsThroughTimeAgreeWithFiniteDifferences) {
  const auto network = small_network(small_recurrent_config(), torch::kFloat64);
  std::vector<NetworkInput> frames;
  for (uint32_t f = 0; f < 3; ++f) frames.push_back(recurrent_input(f, torch::kFloat64, 1, 4, 5));
  const Tensor reference = random_uniform({1, 3, 4, 5}, 5, 0, 4);
  const auto run = [&](const std::vector<Tensor>&) {
    NetworkState state;
    std::vector<Tensor> predicted;
    for (const NetworkInput& frame : frames)
      predicted.push_back(network->compare(frame, reference, state).predicted);
    return at::cat({predicted[1], predicted[2]}, 1);
  };
  expect_gradients(run, network->parameters(), 5);
}

// Variance 2 / ((1 + 0.1^2) inputs), inputs with their taps (He et al. 2015).
TEST(Recurrent, BeginsWithWeightsForItsSlope) {
  const auto network = make_network(published_recurrent());
  initialise(*network, 1);
  for (const auto& parameter : network->named_parameters()) {
    const Tensor& weight = parameter.value();
    if (weight.dim() == 1) {
      EXPECT_EQ(weight.abs().max().item<double>(), 0);
      continue;
    }
    const double variance = 2 / (1.01 * 9 * double(weight.size(1)));
    const double error = 4 * std::sqrt(0.8 / double(weight.numel()));  // of the variance of a uniform one
    EXPECT_NEAR(weight.square().mean().item<double>() / variance, 1, error) << parameter.key();
  }
}

TEST(Recurrent, WhatCannotBeIsAnError) {
  const NetworkConfig config = small_recurrent_config();
  const auto network = small_network(config, torch::kFloat32);
  NetworkState state;
  network->forward(recurrent_input(0, torch::kFloat32, 2, 6, 7), state);
  EXPECT_ERROR(network->forward(recurrent_input(0, torch::kFloat32, 1, 6, 7), state), "network: state");
  EXPECT_EQ(state.at("h0").size(0), 2) << "and nothing has changed";
  EXPECT_ERROR(network->kernels(recurrent_input(0, torch::kFloat32)), "has no kernels");
  const auto refused = [&](auto set, const char* why) {
    NetworkConfig other = config;
    set(other);
    EXPECT_ERROR(make_network(other), why);
  };
  refused([](NetworkConfig& c) { c.demodulation = "albedo"; }, "divides by the albedo by itself");
  refused([](NetworkConfig& c) { c.means = true; }, "network.means is given");
  refused([](NetworkConfig& c) { c.exposure_normalisation = true; },
          "network.exposure_normalisation is given");
  refused([](NetworkConfig& c) { c.initial_kernel = 1; }, "has no kernels");
  refused([](NetworkConfig& c) { c.rejection = true; }, "sends nothing");
  NetworkConfig other = small_config();
  other.recurrence = false;
  EXPECT_ERROR(make_network(other), "has no recurrent blocks");
}

}  // namespace
}  // namespace ld
