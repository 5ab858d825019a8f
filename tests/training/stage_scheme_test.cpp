// The four ways to train a network in two stages.
#include "training/optimizer/stage_scheme.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/file_io.h"
#include "core/log.h"
#include "frame/derived_features.h"
#include "metrics/psnr.h"
#include "models/initialise.h"
#include "tests/support/expect_error.h"
#include "tests/support/tensors.h"
#include "tests/training/tiny_training.h"
#include "training/optimizer/optimizer.h"
#include "training/training_data.h"

namespace ld {
namespace {

using torch::Tensor;

class StageScheme : public ::testing::Test {
 protected:
  void SetUp() override { write_tiny_dataset(folder_ / "data", 6, 16, 4); }

  TrainConfig config(const std::string& scheme, int64_t steps = 10) const {
    TrainConfig config = tiny_config(folder_ / "data", steps);
    config.network.name = "espcn_kpcn";
    config.network.features = {"radiance", "normal", "albedo"};
    config.network.super_resolution.convolutions = {6, 5};
    config.network.super_resolution.denoiser = 4;
    config.loss = "l2_tonemapped";
    config.data.samples = {1, 1};
    config.optimizer.scheme = scheme;
    return config;
  }

  static std::shared_ptr<Network> network_of(const TrainConfig& config) {
    std::shared_ptr<Network> network = make_network(config.network);
    initialise(*network, 3);
    return network;
  }

  /// Gradients of the loss of a batch, by parameter.
  static std::map<std::string, Tensor> gradients(const TrainConfig& config, Network& network) {
    TrainingSet set = make_training_set(config);
    Batch batch = set.batch(0);
    forget_gradients(network);
    batch_loss(network, batch, make_clip_loss({}, make_loss(config.loss)), config.optimizer).backward();
    std::map<std::string, Tensor> gradients;
    for (const auto& entry : network.named_parameters())
      gradients[entry.key()] =
          entry.value().grad().defined() ? entry.value().grad().clone() : torch::zeros_like(entry.value());
    return gradients;
  }

  /// All parameters after so many steps.
  Tensor trained(const TrainConfig& config, int64_t steps) const {
    const std::shared_ptr<Network> network = network_of(config);
    TrainingSet set = make_training_set(config);
    ProcessGroup alone{ProcessGroupOptions{}};
    Optimizer optimizer(network, config.optimizer);
    const ClipLoss loss = make_clip_loss({}, make_loss(config.loss));
    for (int64_t step = 0; step < steps; ++step)
      EXPECT_TRUE(optimizer.step(set, step, loss, 0.01, step + 1, alone).taken);
    return all_parameters(*network);
  }

  TemporaryFolder folder_;
};

bool of_first_stage(const std::string& parameter) {
  return parameter.rfind("super_resolution.", 0) == 0;
}

TEST_F(StageScheme, TheNoisyPictureIsOfSamplesThatTheNetworkDoesNotSee) {
  TrainConfig c = config("concurrent");
  c.data.flips = c.data.rotations = false;
  c.data.crop = 16;
  c.data.batch = 1;
  TrainingSet set = make_training_set(c);
  const Batch batch = set.batch(0);
  ASSERT_EQ(batch.noisy.sizes(), (std::vector<int64_t>{1, 3, 16, 16}));
  ASSERT_EQ(batch.input.radiance.size(1), 1);
  int seen = 0, other = 0;
  for (int frame = 0; frame < 6; ++frame) {
    const Frame whole = random_frame(16, 16, 4, static_cast<uint32_t>(frame));
    for (int s = 0; s < 4; ++s) {
      const Tensor sample = torch::from_blob(const_cast<float*>(whole.plane(s, 0)), {1, 3, 16, 16});
      seen += batch.input.radiance.select(1, 0).equal(sample) ? 1 : 0;
      other += batch.noisy.equal(sample) ? 1 : 0;
    }
  }
  EXPECT_EQ(seen, 1);
  EXPECT_EQ(other, 1);
  EXPECT_FALSE(batch.noisy.equal(batch.input.radiance.select(1, 0)));
  EXPECT_FALSE(make_training_set(config("end_to_end")).batch(0).noisy.defined());
}

// Each stage learns from its own loss as if the other were not there.
TEST_F(StageScheme, SeparateAndConcurrentKeepTheStagesApart) {
  for (const char* scheme : {"separate", "concurrent"}) {
    const TrainConfig c = config(scheme);
    const std::shared_ptr<Network> network = network_of(c);
    const auto found = gradients(c, *network);
    TrainingSet set = make_training_set(c);
    Batch batch = set.batch(0);
    forget_gradients(*network);
    make_loss(c.loss)(network->stages(batch.input, SecondReads::first).first, batch.noisy).backward();
    for (const auto& entry : network->named_parameters()) {
      if (of_first_stage(entry.key()))
        EXPECT_TRUE(entry.value().grad().equal(found.at(entry.key()))) << scheme << " " << entry.key();
      else
        EXPECT_GT(found.at(entry.key()).abs().sum().item<double>(), 0) << scheme << " " << entry.key();
    }
  }
}

TEST_F(StageScheme, TwoHeadsAddTheFirstStagesLossByItsWeight) {
  TrainConfig c = config("two_heads");
  const std::shared_ptr<Network> network = network_of(c);
  const auto gradients_at = [&](double weight) {
    c.optimizer.head_weight = weight;
    return gradients(c, *network);
  };
  const auto none = gradients_at(0), one = gradients_at(1), three = gradients_at(3);
  for (const auto& [name, gradient] : one) {
    const Tensor expected = none.at(name) + 3 * (gradient - none.at(name));
    EXPECT_LE(largest_difference(three.at(name), expected), 1e-5) << name;
    if (of_first_stage(name)) {
      EXPECT_GT(largest_difference(gradient, none.at(name)), 0) << name;
    } else {
      EXPECT_LE(largest_difference(gradient, none.at(name)), 1e-7) << name;
    }
  }
}

TEST_F(StageScheme, TwoHeadsOfWeight0AreEndToEndStepForStep) {
  TrainConfig heads = config("two_heads");
  heads.optimizer.head_weight = 0;
  for (const int64_t steps : {1, 2, 7})
    EXPECT_TRUE(trained(heads, steps).equal(trained(config("end_to_end"), steps))) << steps;
  heads.optimizer.head_weight = 1;
  EXPECT_FALSE(trained(heads, 3).equal(trained(config("end_to_end"), 3)));
}

TEST_F(StageScheme, EachSchemeLearns) {
  for (const char* scheme : {"separate", "concurrent", "end_to_end", "two_heads"}) {
    TrainConfig c = config(scheme, 120);
    c.optimizer.learning_rate = 0.01;
    c.optimizer.schedule = "constant";
    c.run.log_every = 10;
    c.run.validate_every = 60;
    Trainer trainer(c, folder_ / scheme);
    trainer.train();
    spdlog::default_logger()->flush();
    const std::string metrics = read_file(folder_ / scheme / "metrics.csv"),
                      log = read_file(folder_ / scheme / "train.log");
    EXPECT_NE(log.find("first stage: PSNR"), std::string::npos) << log;
    const auto losses = [&] {
      std::vector<double> found;
      size_t column = 0;
      std::istringstream lines(metrics);
      std::string line, cell;
      std::getline(lines, line);
      std::istringstream header(line);
      for (size_t i = 0; std::getline(header, cell, ','); ++i)
        if (cell == "train_loss") column = i;
      while (std::getline(lines, line)) {
        std::istringstream cells(line);
        for (size_t i = 0; std::getline(cells, cell, ','); ++i)
          if (i == column && !cell.empty()) found.push_back(std::stod(cell));
      }
      return found;
    }();
    ASSERT_GE(losses.size(), 6U) << metrics;
    EXPECT_LT(losses.back(), 0.8 * losses.front()) << scheme;
  }
}

TEST_F(StageScheme, ThePsnrOfTheFirstStageIsThatOfTheMetric) {
  const TrainConfig c = config("end_to_end");
  Validation validation(make_validation_stores(c), 0, validation_samples(c.data));
  const std::shared_ptr<Network> network = network_of(c);
  ProcessGroup alone{ProcessGroupOptions{}};
  const std::optional<FirstStageScore> score =
      validation.score_first_stage(*network, noisy_beside(c.network), alone);
  ASSERT_TRUE(score.has_value());
  // The validation frame is the seventh; its first sample is read, the second stands beside.
  const Frame frame = random_frame(16, 16, 4, 6);
  Frame first = frame;
  first.spp = 1;
  first.samples.resize(first.plane_size() * static_cast<size_t>(first.channels));
  first.valid.resize(first.plane_size());
  Image noisy(16, 16, 3), reference = mean_radiance(frame);
  std::copy_n(frame.plane(1, 0), noisy.pixels.size(), noisy.pixels.begin());
  const torch::NoGradGuard no_graph;
  const NetworkInput input = make_network_input({first}, c.network.features);
  const Image made = to_image(network->stages(input, SecondReads::first).first.squeeze(0));
  EXPECT_NEAR(score->psnr, psnr(made, noisy), 0.01);
  EXPECT_NEAR(score->floor, psnr(reference, noisy), 0.01);
  EXPECT_EQ(noisy_beside(tiny_config(folder_ / "data", 1).network), Noisy::none);
}

TEST_F(StageScheme, LightAtHalfResolutionIsReadAndItsCropsBeginAtEvenPixels) {
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "data")) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("frame_", 0) == 0 && name.find('.') == name.rfind('.') &&
        name.find("reference") == std::string::npos)
      write_frame(half_companion(entry.path()), random_frame(8, 8, 4, 77));
  }
  TrainConfig c = config("separate");
  c.network.features = {"half_radiance", "normal"};
  const Batch batch = make_training_set(c).batch(0);
  const Tensor light = batch.input.features.narrow(2, 0, 3);
  EXPECT_TRUE(light.slice(3, 0, 8, 2).equal(light.slice(3, 1, 8, 2)));
  EXPECT_TRUE(light.slice(4, 0, 8, 2).equal(light.slice(4, 1, 8, 2)));
  EXPECT_GT(light.std().item<double>(), 0);
  EXPECT_TRUE(batch.noisy.equal(batch.input.radiance.select(1, 0))) << "of its own random numbers";
  c.data.crop = 7;
  EXPECT_ERROR(make_training_set(c), "data.crop: 7");
}

TEST_F(StageScheme, WhatDoesNotFitIsNamed) {
  TrainConfig c = tiny_config(folder_ / "data", 1);
  c.optimizer.scheme = "concurrent";
  EXPECT_ERROR(make_training_set(c), "network 'layer' has one stage");
  write_tiny_dataset(folder_ / "single", 3, 16, 1);
  c = config("concurrent");
  c.data.path = (folder_ / "single").string();
  EXPECT_ERROR(make_training_set(c), "has 1 sample a pixel; a first stage that learns from noise");
}

}  // namespace
}  // namespace ld
