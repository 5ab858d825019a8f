// Layers that remember: against plain loops, against the network that remembers nothing, at the extremes, and
// the gradient through time.
#include "models/history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/models/plain_history.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"
#include "tests/support/gradient_check.h"

namespace ld {
namespace {

using torch::Tensor;

NetworkConfig history_config(const std::string& name = "layer_history") {
  NetworkConfig config = small_config();
  config.name = name;
  config.features = {"radiance", "specular", "depth", "albedo", "normal", "flow"};
  config.demodulation = "albedo";
  return config;
}

/// Frame `f` of a sequence: surfaces that pass the tests nearly everywhere, and flow of up to a pixel.
NetworkInput frame_input(const NetworkConfig& config, uint32_t f, torch::ScalarType type, int64_t b = 2,
                         int64_t h = 6, int64_t w = 7) {
  NetworkInput input = random_input(config, b, 3, h, w, torch::kFloat64, 10 + 10 * f);
  const auto set = [&](const char* name, const Tensor& values) {
    if (const int64_t first = first_channel(config.features, name); first >= 0)
      input.features.narrow(2, first, values.size(2)) = values * input.valid;
  };
  set("depth", random_uniform({b, 3, 1, h, w}, 500 + f, 0.48, 0.52));
  set("normal", random_normal({b, 3, 3, h, w}, 600 + f, 0.2) + 1);
  set("flow", random_uniform({b, 3, 2, h, w}, 700 + f, -0.06, 0.06));
  return to_type(input, type);
}

/// All parameters that both have.
void copy_parameters(Network& from, Network& to) {
  const torch::NoGradGuard no_gradient;
  auto named = to.named_parameters();
  for (const auto& parameter : from.named_parameters())
    if (auto* same = named.find(parameter.key())) same->copy_(parameter.value());
}

TEST(History, AgreesWithPlainLoops) {
  const NetworkConfig config = history_config();
  History history(config);
  const torch::NoGradGuard no_gradient;
  uint32_t seed = 30;
  for (Tensor& parameter : history.parameters())
    parameter.copy_(random_normal(parameter.sizes(), seed++, 0.5));
  history.to(torch::kFloat64);
  const auto named = history.named_parameters();
  const Tensor w0 = named["gate.0.weight"], b0 = named["gate.0.bias"], w1 = named["gate.1.weight"],
               b1 = named["gate.1.bias"];
  NetworkState state;
  PlainState plain;
  for (uint32_t f = 0; f < 4; ++f) {
    const NetworkInput input = frame_input(config, f, torch::kFloat64, 1, 9, 8);
    const Tensor light = random_uniform({1, 6, 9, 8}, 40 + f, 0, 4),
                 context = random_normal({1, config.unet.context, 9, 8}, 50 + f);
    const auto logits = [&](const Tensor& seen) {
      const Tensor x = at::cat({seen, context}, 1);
      const Tensor hidden = at::leaky_relu(at::conv2d(x, w0.view({w0.size(0), -1, 1, 1}), b0), 0.01);
      return at::conv2d(hidden, w1.view({1, -1, 1, 1}), b1);
    };
    const Tensor expected = plain_remembered(light, input, config, logits, plain);
    expect_near(history.remembered(light, context, input, config, state), expected, 1e-12);
    expect_near(state.at("frames"), plain.frames, 1e-12);
    expect_near(state.at("surface"), plain.surface, 1e-15);
    if (f > 0) {
      EXPECT_GT((expected - light).abs().max().item<double>(), 0.1) << "nothing of the past is in it";
      EXPECT_GT(plain.frames.max().item<double>(), 1.01);
    }
  }
}

TEST(History, WithoutOneItIsTheLayerNetworkBitForBit) {
  for (const torch::ScalarType type : {torch::kFloat32, torch::kFloat64}) {
    const auto layer = small_network(history_config("layer"), type),
               remembering = small_network(history_config(), type);
    copy_parameters(*layer, *remembering);
    const torch::NoGradGuard no_gradient;
    NetworkState state;
    const NetworkInput first = frame_input(history_config(), 0, type);
    EXPECT_TRUE(remembering->forward(first, state).equal(layer->forward(first)));
    EXPECT_EQ(state.size(), 3U);
    // Everything comes from outside of the picture: a cut.
    NetworkInput cut = frame_input(history_config(), 1, type);
    cut.features.narrow(2, first_channel(history_config().features, "flow"), 2).fill_(65504.0 / 65520);
    EXPECT_TRUE(remembering->forward(cut, state).equal(layer->forward(cut)));
    // Zeros are as good as nothing.
    for (auto& [name, tensor] : state) tensor = torch::zeros_like(tensor);
    const NetworkInput next = frame_input(history_config(), 2, type);
    EXPECT_TRUE(remembering->forward(next, state).equal(layer->forward(next)));
    EXPECT_FALSE(remembering->forward(next, state).equal(layer->forward(next)));
    // And a network that remembers nothing leaves the state alone.
    NetworkState none;
    layer->forward(next, none);
    EXPECT_TRUE(none.empty());
  }
}

// What the gate compares is held fixed, as is what it does not believe: without them the gradient is the
// whole derivative.
TEST(History, GradientsThroughTimeAgreeWithFiniteDifferences) {
  NetworkConfig config = history_config();
  const auto network = small_network(config, torch::kFloat64);
  {
    const torch::NoGradGuard no_gradient;
    network->named_parameters()["history.gate.0.weight"].narrow(1, 0, 3).zero_();
  }
  std::vector<NetworkInput> frames;
  for (uint32_t f = 0; f < 3; ++f) {
    NetworkInput input = with_one_reflectance(frame_input(config, f, torch::kFloat64, 1, 4, 5), config);
    input.radiance = random_uniform(input.radiance.sizes(), 800 + f, 2, 3) * input.valid;
    frames.push_back(input);
  }
  std::vector<Tensor> inputs = network->parameters();
  inputs.push_back(variable(frames[0].radiance));
  const auto run = [&](const std::vector<Tensor>& v) {
    NetworkState state;
    std::vector<Tensor> pictures;
    for (size_t f = 0; f < frames.size(); ++f) {
      NetworkInput input = frames[f];
      if (f == 0) input.radiance = v.back();
      pictures.push_back(network->forward(input, state));
    }
    return at::cat({pictures.back(), state.at("frames")}, 1);
  };
  expect_gradients(run, inputs, 6);
}

/// A gate of this bias alone.
std::shared_ptr<Network> with_gate(const NetworkConfig& config, double bias) {
  const auto network = small_network(config, torch::kFloat32);
  const torch::NoGradGuard no_gradient;
  auto named = network->named_parameters();
  named["history.gate.1.weight"].zero_();
  named["history.gate.1.bias"].fill_(bias);
  return network;
}

// A still of 1,000 frames of one light neither grows nor drifts, whatever share of the past is kept.
TEST(History, NothingGrowsOrDrifts) {
  NetworkConfig config = history_config();
  for (const double bias : {-3.0, 0.0, 3.0, 30.0}) {
    const auto network = with_gate(config, bias);
    NetworkInput input = with_one_reflectance(frame_input(config, 0, torch::kFloat32, 1), config);
    input.features.narrow(2, first_channel(config.features, "flow"), 2).zero_();
    input.radiance = (input.valid * 2.5).expand({1, 3, 3, 6, 7}).contiguous();
    const torch::NoGradGuard no_gradient;
    NetworkState state;
    Tensor picture;
    for (int f = 0; f < 1000; ++f) picture = network->forward(input, state);
    EXPECT_LE((picture / 2.5 - 1).abs().max().item<double>(), 1e-3) << bias;
    EXPECT_LE(state.at("frames").max().item<double>(), 32);
  }
}

// As it begins, the gate keeps some of a light that stays, and lets go of one that went out or came on.
TEST(History, BeginsByLettingGoOfLightThatHasChanged) {
  for (const std::vector<int64_t>& hidden : std::vector<std::vector<int64_t>>{{}, {16}, {5, 4}}) {
    NetworkConfig config = history_config();
    config.history = hidden;
    History history(config);
    history.initialise();
    NetworkInput input = frame_input(config, 0, torch::kFloat32, 1);
    input.valid.fill_(1);
    input.features.narrow(2, first_channel(config.features, "flow"), 2).zero_();
    const torch::NoGradGuard no_gradient;
    const Tensor context = torch::zeros({1, config.unet.context, 6, 7});
    const auto second = [&](double before, double now) {
      NetworkState state;
      history.remembered(torch::full({1, 3, 6, 7}, before), context, input, config, state);
      return history.remembered(torch::full({1, 3, 6, 7}, now), context, input, config, state)
          .max()
          .item<double>();
    };
    EXPECT_LE(second(8, 0), 1e-6);
    EXPECT_NEAR(second(0, 8), 8, 1e-6);
    const double s = 0.01 / 2.01, k = 1 / (1 + std::exp(1 + 20 * s));
    EXPECT_NEAR(second(1, 1.01), 1.01 - 0.01 * k, 1e-5);
  }
}

// No gate keeps what is brighter than twice the present light: one bright sample is gone a frame later.
TEST(History, OneBrightPixelIsNotHandedOn) {
  NetworkConfig config = history_config();
  History history(config);
  torch::NoGradGuard no_gradient;
  history.named_parameters()["gate.1.bias"].fill_(30);
  NetworkInput input = frame_input(config, 0, torch::kFloat32, 1);
  input.valid.fill_(1);
  input.features.narrow(2, first_channel(config.features, "flow"), 2).zero_();
  const Tensor context = torch::zeros({1, config.unet.context, 6, 7}), dark = torch::full({1, 6, 6, 7}, 0.1);
  Tensor bright = dark.clone();
  bright.select(3, 3).select(2, 2).fill_(1000);
  NetworkState state;
  history.remembered(bright, context, input, config, state);
  for (int f = 0; f < 4; ++f)
    EXPECT_LE(history.remembered(dark, context, input, config, state).max().item<double>(), 0.2 * (1 + 1e-6));
  // The dark ones beside it have all of their past.
  EXPECT_NEAR(state.at("light").min().item<double>(), 0.1, 1e-6);
}

// With g = 0 the light is the mean over all frames, and counts for as many.
TEST(History, AGateOfZeroIsTheMeanOverAllFrames) {
  NetworkConfig config = history_config();
  History history(config);  // weights of zeros
  NetworkInput input = frame_input(config, 0, torch::kFloat32, 1);
  input.valid.fill_(1);
  input.features.narrow(2, first_channel(config.features, "flow"), 2).zero_();
  const torch::NoGradGuard no_gradient;
  NetworkState state;
  Tensor sum = torch::zeros({1, 3, 6, 7});
  for (uint32_t f = 0; f < 20; ++f) {
    const Tensor light = random_uniform({1, 3, 6, 7}, f, 2, 4).to(torch::kFloat32);
    sum = sum + light;
    const Tensor mean =
        history.remembered(light, torch::zeros({1, config.unet.context, 6, 7}), input, config, state);
    expect_near(mean, sum / (f + 1.0), 1e-5);
    expect_near(state.at("frames"), torch::full({1, 1, 6, 7}, f + 1.0), 1e-4);
  }
}

TEST(History, StaysBetweenPastAndPresentAtTheExtremes) {
  NetworkConfig config = history_config();
  const std::vector<float> values = {0, 1e-45F, 1e-38F, 1, 65504, 1e35F, 3e38F};
  History history(config);
  uint32_t seed = 30;
  {
    const torch::NoGradGuard no_gradient;
    for (Tensor& parameter : history.parameters()) parameter.copy_(random_normal(parameter.sizes(), seed++));
  }
  NetworkInput input = frame_input(config, 0, torch::kFloat32, 1, 1, 1);
  input.valid.fill_(1);
  input.features.narrow(2, first_channel(config.features, "flow"), 2).zero_();
  for (const float before : values)
    for (const float now : values) {
      NetworkState state;
      const Tensor context = torch::full({1, config.unet.context, 1, 1}, 1e4F),
                   first = torch::full({1, 3, 1, 1}, double(before), torch::kFloat32),
                   second = torch::full({1, 3, 1, 1}, double(now), torch::kFloat32).set_requires_grad(true);
      history.remembered(first, context, input, config, state);
      const Tensor light = history.remembered(second, context, input, config, state);
      EXPECT_GE(light.min().item<double>(), double(std::min(before, now)) * (1 - 1e-6))
          << before << " " << now;
      EXPECT_LE(light.max().item<double>(), double(std::max(before, now)) * (1 + 1e-6))
          << before << " " << now;
      (light * 1e-30).sum().backward();
      EXPECT_TRUE(all_finite(second.grad())) << before << " " << now;
    }
}

TEST(History, OtherSurfacesAndPixelsWithoutSamplesHaveNone) {
  NetworkConfig config = history_config();
  const auto network = with_gate(config, 3);
  const torch::NoGradGuard no_gradient;
  NetworkInput first = frame_input(config, 0, torch::kFloat32, 1);
  first.valid.fill_(1);
  first.valid.select(3, 0).zero_();
  const auto feature = [&](NetworkInput& input, const char* name) {
    return input.features.narrow(2, first_channel(config.features, name), find_feature(name).channels);
  };
  feature(first, "flow").zero_();
  feature(first, "depth").fill_(0.5);
  feature(first, "normal").fill_(1);
  NetworkInput second = first;
  second.features = first.features.clone();
  feature(second, "depth").select(3, 2).fill_(0.9);
  feature(second, "normal").select(3, 4).fill_(-1);
  NetworkState state;
  network->forward(first, state);
  EXPECT_EQ(state.at("frames").select(2, 0).max().item<double>(), 0);
  network->forward(second, state);
  const Tensor frames = state.at("frames");
  EXPECT_EQ(frames.select(2, 0).max().item<double>(), 0);
  for (const int64_t row : {2, 4}) EXPECT_EQ(frames.select(2, row).max().item<double>(), 1) << row;
  for (const int64_t row : {1, 3, 5}) EXPECT_GT(frames.select(2, row).min().item<double>(), 1) << row;
}

TEST(History, AStateThatDoesNotFitIsAnError) {
  const NetworkConfig config = history_config();
  const auto network = small_network(config, torch::kFloat32);
  NetworkState state;
  network->forward(frame_input(config, 0, torch::kFloat32, 2, 6, 7), state);
  NetworkState other = state;
  EXPECT_ERROR(network->forward(frame_input(config, 1, torch::kFloat32, 1, 6, 7), other), "network: state");
  other = state;
  EXPECT_ERROR(network->forward(frame_input(config, 1, torch::kFloat32, 2, 7, 6), other), "network: state");
  NetworkConfig forgetful = config;
  forgetful.optional = {"flow"};
  EXPECT_ERROR(make_network(forgetful), "network.optional names 'flow'");
  forgetful = config;
  forgetful.name = "layer";
  forgetful.history = {8};
  EXPECT_ERROR(make_network(forgetful), "keeps nothing from frame to frame");
}

}  // namespace
}  // namespace ld
