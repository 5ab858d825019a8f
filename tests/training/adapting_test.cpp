// Trainings on noisy frames alone.
#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "tests/support/expect_error.h"
#include "tests/training/tiny_training.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

constexpr float kMean = 0.5F;
constexpr int kSide = 80;  // 9 blocks a frame, of which two in six are held out

/// Frames of one colour whose samples are exponentially distributed, as light that few paths find.
void write_exponential_shot(const fs::path& folder, int frames, int size, int spp, bool repeated = false) {
  fs::create_directories(folder);
  for (int i = 0; i < frames; ++i) {
    Frame frame = random_frame(size, size, spp, static_cast<uint32_t>(i));
    std::fill(frame.valid.begin(), frame.valid.end(), uint8_t{1});
    for (int s = 0; s < spp; ++s)
      for (int c = 0; c < 3; ++c)
        for (size_t p = 0; p < frame.plane_size(); ++p) {
          RandomStream stream(3, RandomPurpose::test, static_cast<uint32_t>(i), static_cast<uint32_t>(p),
                              static_cast<uint32_t>(repeated ? c : 3 * s + c));
          frame.plane(s, kRadianceOffset + c)[p] =
              -kMean * std::log(1 - static_cast<float>(stream.uniform()));
        }
    write_frame(frame_path(folder, "f" + std::to_string(i)), frame);
  }
}

TrainConfig adapting(const fs::path& shot, int64_t steps, const std::string& loss = "relative_l2") {
  TrainConfig config = tiny_config(shot, 0);
  config.network.features = {"radiance"};
  config.loss = loss;
  config.data.targets = "samples";
  config.data.held_out = 3;
  config.data.crop = 16;
  config.optimizer.learning_rate = 0.01;
  config.steps = steps;
  config.run = {0, 50, 100, 100};
  return config;
}

/// Of all pixels of a shot that the trained network denoised.
double mean_of_denoised(Trainer& trainer, const fs::path& shot, int frames) {
  double sum = 0;
  for (int i = 0; i < frames; ++i) {
    Faults faults;
    const Frame frame = read_frame(frame_path(shot, "f" + std::to_string(i)), {}, faults);
    const torch::NoGradGuard no_graph;
    auto& network = const_cast<Network&>(trainer.averaged_network());
    sum += network.forward(make_network_input({frame}, {"radiance"})).mean().item<double>() / frames;
  }
  return sum;
}

/// A pixel network sees which pixels are bright, and may leave them out.
TEST(Adapting, LearnsTheMeanOfNoisyTargetsAndWithL1SomethingDarker) {
  const TemporaryFolder folder;
  write_exponential_shot(folder / "shot", 6, kSide, 4);
  for (const auto& [loss, bias] : {std::pair("relative_l2", 0.01), std::pair("l1", -0.04)}) {
    SCOPED_TRACE(loss);
    Trainer trainer(adapting(folder / "shot", 500, loss), folder / loss);
    trainer.train();
    const double error = mean_of_denoised(trainer, folder / "shot", 6) / kMean - 1;
    if (bias > 0)
      EXPECT_LT(std::fabs(error), bias);
    else
      EXPECT_LT(error, bias);
  }
}

TEST(Adapting, RepeatedSamplesAreRefusedAndTheBeginningIsTheBest) {
  const TemporaryFolder folder;
  write_exponential_shot(folder / "shot", 6, kSide, 4, true);
  for (int pass = 0; pass < 2; ++pass) {  // also when the command is given again
    Trainer trainer(adapting(folder / "shot", 50), folder / "run");
    trainer.train();
    EXPECT_EQ(trainer.state().step, 0);
    EXPECT_NE(trainer.verdict().find("share noise"), std::string::npos) << trainer.verdict();
    EXPECT_TRUE(fs::exists(folder / "run/checkpoints/best/weights.safetensors"));
  }
}

TEST(Adapting, TooFewBlocksAreRefused) {
  const TemporaryFolder folder;
  write_exponential_shot(folder / "shot", 4, 32, 4);
  Trainer trainer(adapting(folder / "shot", 50), folder / "run");
  trainer.train();
  EXPECT_EQ(trainer.state().step, 0);
  EXPECT_NE(trainer.verdict().find("1 blocks"), std::string::npos) << trainer.verdict();
}

TEST(Adapting, HandsOutTheBeginningWhereNothingIsGained) {
  const TemporaryFolder folder;
  write_exponential_shot(folder / "shot", 6, kSide, 4);
  TrainConfig config = adapting(folder / "shot", 200);
  config.optimizer.learning_rate = 0;
  Trainer trainer(config, folder / "run");
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  trainer.train();
  const std::string said = testing::internal::GetCapturedStderr() + testing::internal::GetCapturedStdout();
  EXPECT_NE(said.find("against noisy samples that it does not see"), std::string::npos) << said;
  EXPECT_EQ(said.find("PSNR"), std::string::npos) << "beside noisy samples it says nothing of the picture";
  EXPECT_EQ(trainer.state().step, 200);
  EXPECT_EQ(trainer.state().best_step, 0);
  EXPECT_NE(trainer.verdict().find("weights of the beginning stay the best"), std::string::npos)
      << trainer.verdict();
}

TEST(Adapting, TwoHalvesAreTheWhole) {
  const TemporaryFolder folder;
  write_exponential_shot(folder / "shot", 6, kSide, 4);
  const auto train = [&](const std::string& run, int64_t until) {
    TrainConfig config = adapting(folder / "shot", 40);
    config.run = {until, 5, 10, 10};
    Trainer trainer(config, folder / run);
    trainer.train();
    return trainer.verdict();
  };
  const std::string verdict = train("straight", 0);
  train("halves", 20);
  EXPECT_EQ(train("halves", 0), verdict);
  EXPECT_EQ(last_checkpoint(folder / "straight"), last_checkpoint(folder / "halves"));
  EXPECT_EQ(read_file(folder / "straight/metrics.csv"), read_file(folder / "halves/metrics.csv"));
}

TEST(Adapting, TakesTheNetworkOfTheWeightsItBeginsWith) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "data", 4, 64, 4);
  TrainConfig first = tiny_config(folder / "data", 2);
  first.network.features = {"radiance", "normal", "flow"};
  first.network.optional = {"flow"};
  first.data.path = (folder / "data").string();
  EXPECT_ERROR(Trainer(first, folder / "first"), "lacks the feature 'flow'");
  first.network.features = {"radiance", "normal"};
  first.network.optional = {};
  Trainer(first, folder / "first").train();
  TrainConfig config = adapting(folder / "data", 20);
  config.network = NetworkConfig();
  config.network.name = kNetworkOfInit;
  EXPECT_ERROR(Trainer(config, folder / "second"), "init is empty");
  EXPECT_ERROR(Trainer(config, folder / "second"), "init=FILE_OR_NAME");
  config.init = (folder / "first").string();
  const Trainer trainer(config, folder / "second");
  EXPECT_EQ(trainer.network().config().features, first.network.features);
  EXPECT_EQ(trainer.network().config().kernel_size, 3);
}

TEST(Adapting, OneSampleAPixelIsTooFew) {
  const TemporaryFolder folder;
  write_exponential_shot(folder / "shot", 4, 32, 1);
  EXPECT_ERROR(Trainer(adapting(folder / "shot", 5), folder / "run"), "has 1 sample a pixel");
  EXPECT_ERROR(Trainer(adapting(folder / "shot", 5), folder / "run"), "2 or more");
}

}  // namespace
}  // namespace ld
