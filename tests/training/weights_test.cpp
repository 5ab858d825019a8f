// What a run begins with, averages and accumulates.
#include <gtest/gtest.h>

#include "models/initialise.h"
#include "tests/models/small_config.h"
#include "tests/support/expect_error.h"
#include "tests/support/tensors.h"
#include "tests/training/tiny_training.h"
#include "training/fine_tuning.h"
#include "training/training_data.h"
#include "weights/mix_weights.h"
#include "weights/model_file.h"

namespace ld {
namespace {

NetworkConfig tiny_network(const std::string& name, const std::vector<std::string>& features) {
  auto config = config_from_tree<TrainConfig>(parse_config(tiny_network_yaml(), "tiny")).network;
  config.name = name;
  config.features = features;
  if (network_traits(name).has_levels) config.levels = 2;
  return config;
}

std::shared_ptr<Network> random_network(const NetworkConfig& config, uint64_t seed) {
  std::shared_ptr<Network> network = make_network(config);
  initialise(*network, seed);
  return network;
}

NetworkInput random_input(int64_t channels) {
  const auto values = [](torch::IntArrayRef sizes, uint32_t seed) {
    return random_uniform(sizes, seed).to(torch::kFloat32);
  };
  return {values({1, 2, channels, 9, 7}, 1), values({1, 2, 3, 9, 7}, 2), torch::ones({1, 2, 1, 9, 7})};
}

TEST(WeightAverage, FollowsItsFormula) {
  const std::shared_ptr<Network> network = random_network(tiny_network("layer", {"radiance"}), 1);
  const double decay = 0.7;
  WeightAverage average(network, decay);
  std::vector<double> expected;
  const torch::Tensor begin = all_parameters(*network).to(torch::kFloat64);
  for (int64_t i = 0; i < begin.numel(); ++i) expected.push_back(begin[i].item<double>());
  for (int64_t n = 1; n <= 40; ++n) {
    const torch::NoGradGuard no_graph;
    uint32_t seed = 100 * static_cast<uint32_t>(n);
    for (torch::Tensor& parameter : network->parameters())
      parameter.copy_(random_normal(parameter.sizes(), ++seed));
    average.update(n);
    const double n_real = static_cast<double>(n);
    const double d = std::min(decay, (1 + n_real) / (10 + n_real));
    const torch::Tensor weights = all_parameters(*network);
    for (size_t i = 0; i < expected.size(); ++i)
      expected[i] = d * expected[i] + (1 - d) * weights[static_cast<int64_t>(i)].item<double>();
  }
  const torch::Tensor found = all_parameters(average.network());
  for (size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(found[static_cast<int64_t>(i)].item<double>(), expected[i], 2e-6);
}

TEST(WeightAverage, WithoutDecayTheTrainedWeightsAreUsed) {
  const std::shared_ptr<Network> network = random_network(tiny_network("layer", {"radiance"}), 1);
  WeightAverage average(network, 0);
  EXPECT_FALSE(average.active());
  EXPECT_EQ(&average.network(), network.get());
}

TEST(Accumulation, IsTheGradientOfTheMeanOverAllBatches) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "data", 6);
  TrainConfig config = tiny_config(folder / "data", 1);
  TrainingSet set = make_training_set(config);
  const std::shared_ptr<Network> network = random_network(config.network, 1);
  const Loss loss = make_loss("smape");

  // One graph over the three batches of step 2.
  torch::Tensor mean = torch::zeros({});
  for (int64_t i = 0; i < 3; ++i) {
    const Batch batch = set.batch(6 + i);
    mean = mean + loss(network->forward(batch.input), batch.reference) / 3;
  }
  mean.backward();
  const double norm = gradient_norm(*network);
  forget_gradients(*network);

  config.optimizer.accumulate = 3;
  Optimizer optimizer(network, config.optimizer);
  ProcessGroup alone{ProcessGroupOptions{}};
  const Optimizer::Outcome outcome = optimizer.step(set, 2, make_clip_loss({}, loss), 0.001, 1, alone);
  EXPECT_TRUE(outcome.taken);
  EXPECT_NEAR(outcome.loss, mean.item<double>(), 1e-6 * outcome.loss);
  EXPECT_NEAR(outcome.gradient, norm, 1e-5 * norm);
}

class FineTuning : public ::testing::TestWithParam<std::string> {};

TEST_P(FineTuning, OntoFewerFeaturesIsTheirBeingZero) {
  const TemporaryFolder folder;
  const std::vector<std::string> all = {"radiance", "normal", "depth", "albedo"},
                                 some = {"albedo", "radiance"};
  const std::shared_ptr<Network> wide = random_network(tiny_network(GetParam(), all), 1);
  save_network(folder / "wide.safetensors", *wide, "", DType::f32);
  const std::shared_ptr<Network> narrow = random_network(tiny_network(GetParam(), some), 2);
  begin_with_weights(folder / "wide.safetensors", *narrow);

  const NetworkInput whole = random_input(channel_count(all));
  NetworkInput zeroed = whole, picked = whole;
  zeroed.features = whole.features.clone();
  zeroed.features.narrow(2, 3, 4).zero_();  // normal and depth
  picked.features = torch::cat({whole.features.narrow(2, 7, 3), whole.features.narrow(2, 0, 3)}, 2);
  const torch::NoGradGuard no_graph;
  EXPECT_TRUE(torch::allclose(narrow->forward(picked), wide->forward(zeroed), 1e-5, 1e-6));
  EXPECT_FALSE(torch::allclose(narrow->forward(picked), wide->forward(whole), 1e-3, 1e-4));

  // And back: new features count for nothing yet.
  save_network(folder / "narrow.safetensors", *narrow, "", DType::f32);
  const std::shared_ptr<Network> widened = random_network(tiny_network(GetParam(), all), 3);
  begin_with_weights(folder / "narrow.safetensors", *widened);
  EXPECT_TRUE(torch::allclose(widened->forward(whole), narrow->forward(picked), 1e-5, 1e-6));
}

// The full resolution has e^3 / (e^3 + 1) of two levels, all weights of which are those of the other.
TEST(FineTuningPyramid, BeginsNearTheNetworkOfOneResolution) {
  const TemporaryFolder folder;
  NetworkConfig config = tiny_network("pixel_splat", {"radiance", "normal"});
  config.initial_kernel = 1;
  const std::shared_ptr<Network> flat = random_network(config, 1);
  config.name = "pixel_pyramid";
  config.levels = 2;
  const std::shared_ptr<Network> pyramid = random_network(config, 2);
  for (const auto& network : {flat, pyramid})  // so that kernels of different weights differ
    for (auto& parameter : network->named_parameters())
      if (parameter.key().rfind("levels.logits", 0) != 0) parameter.value().detach().mul_(4);
  save_network(folder / "flat.safetensors", *flat, "", DType::f32);
  const NetworkInput input = random_input(channel_count(config.features));
  const torch::NoGradGuard no_graph;
  const double share = std::exp(3.0) / (std::exp(3.0) + 1), largest = input.radiance.max().item<double>();
  const auto difference = [&] {
    return (pyramid->forward(input) - flat->forward(input)).abs().max().item<double>();
  };
  EXPECT_GT(difference(), (1 - share) * largest);
  begin_with_weights(folder / "flat.safetensors", *pyramid);
  EXPECT_LE(difference(), (1 - share) * largest);
  EXPECT_GT(difference(), 0);
}

// What is between two networks, and what only one of them has.
TEST(MixedWeights, AreBetweenBothAndLeaveAloneWhatTheOtherLacks) {
  const TemporaryFolder folder;
  const std::vector<std::string> features = {"radiance", "normal", "depth"};
  const std::shared_ptr<Network> layer = random_network(tiny_network("layer", features), 1);
  save_network(folder / "layer.safetensors", *layer, "", DType::f32);
  std::vector<std::string> moving = features;
  moving.emplace_back("flow");
  const std::shared_ptr<Network> before = random_network(tiny_network("layer_history", moving), 2),
                                 mixed = random_network(tiny_network("layer_history", moving), 2);
  mix_in_weights(folder / "layer.safetensors", 0.25, *mixed, "--mix");
  const auto own = before->named_parameters(), theirs = layer->named_parameters();
  size_t shared = 0;
  for (const auto& parameter : mixed->named_parameters()) {
    const torch::Tensor* other = theirs.find(parameter.key());
    torch::Tensor expected = own[parameter.key()];
    if (other != nullptr) {
      ++shared;
      torch::Tensor value = *other;
      if (value.sizes() != expected.sizes())
        value = torch::constant_pad_nd(value, {0, expected.size(1) - value.size(1)});
      expected = 0.75 * expected + 0.25 * value;
    }
    EXPECT_TRUE(torch::allclose(parameter.value(), expected, 1e-6, 1e-7)) << parameter.key();
  }
  EXPECT_EQ(shared, theirs.size());
  EXPECT_LT(shared, own.size());
  EXPECT_ERROR(mix_in_weights(folder / "layer.safetensors", 0.5,
                              *random_network(tiny_network("pixel_gather", features), 1), "--mix"),
               "--mix: ");
}

/// Those whose features enter one layer.
std::vector<std::string> tunable_networks() {
  std::vector<std::string> names;
  for (const std::string& name : network_names())
    if (network_traits(name).upscaling == 1 && network_traits(name).filter != Filter::none)
      names.push_back(name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Networks, FineTuning, ::testing::ValuesIn(tunable_networks()),
                         [](const auto& network) { return network.param; });

TEST(FineTuning, WhatDoesNotFitIsNamed) {
  const TemporaryFolder folder;
  const NetworkConfig config = tiny_network("layer", {"radiance"});
  save_network(folder / "a.safetensors", *random_network(config, 1), "", DType::f32);
  NetworkConfig other = config;
  other.kernel_size = 5;
  EXPECT_ERROR(begin_with_weights(folder / "a.safetensors", *random_network(other, 1)),
               "'kernel_generator.1.weight' of");
  other = config;
  other.sample_partitioner = {4, 4};
  EXPECT_ERROR(begin_with_weights(folder / "a.safetensors", *random_network(other, 1)),
               "'sample_partitioner.1.weight' of");
  EXPECT_ERROR(begin_with_weights(folder / "a.safetensors",
                                  *random_network(tiny_network("pixel_gather", {"radiance"}), 1)),
               "which the network 'pixel_gather' has not");
  EXPECT_ERROR(begin_with_weights(folder / "none", *random_network(config, 1)), "no such model");
}

TEST(FineTuning, ARunBeginsWithTheWeightsAndContinuesWithoutThem) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "data", 4);
  TrainConfig config = tiny_config(folder / "data", 10);
  Trainer(config, folder / "first").train();
  config.init = (folder / "first").string();
  {
    Trainer second(config, folder / "second");
    EXPECT_TRUE(all_parameters(second.network()).equal(all_parameters(*load_network(folder / "first"))));
    second.train();
  }
  std::filesystem::remove_all(folder / "first");
  config.run.max_steps = 20;
  Trainer second(config, folder / "second");
  EXPECT_EQ(second.state().step, 10);
}

}  // namespace
}  // namespace ld
