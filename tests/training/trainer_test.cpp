#include "training/trainer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "core/error.h"
#include "core/file_io.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"
#include "training/run_folder.h"
#include "training/schedule.h"
#include "weights/model_file.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

TrainConfig tiny_config(const fs::path& data, int64_t max_steps) {
  auto config = config_from_tree<TrainConfig>(parse_config(tiny_network_yaml(), "tiny"));
  config.data.path = data.string();
  config.data.crop = 8;
  config.data.batch = 2;
  config.optimizer.schedule = "cosine";
  config.run = {max_steps, 5, 10, 10};
  return config;
}

/// The weights and the optimiser of the last checkpoint, as bytes.
std::string last_checkpoint(const fs::path& run) {
  return read_file(run / "checkpoints/last/weights.safetensors") +
         read_file(run / "checkpoints/last/optimizer.safetensors");
}

class TrainerTest : public ::testing::Test {
 protected:
  void SetUp() override { write_tiny_dataset(folder_ / "data", 4); }
  void train(const std::string& run, int64_t steps, uint64_t seed = 1) {
    TrainConfig config = tiny_config(folder_ / "data", steps);
    config.seed = seed;
    Trainer trainer(config, folder_ / run);
    trainer.train();
    EXPECT_EQ(trainer.state().step, steps);
  }
  TemporaryFolder folder_;
};

TEST_F(TrainerTest, StoppingAndContinuingChangesNoBit) {
  train("straight", 40);
  train("halves", 20);
  train("halves", 40);
  EXPECT_EQ(last_checkpoint(folder_ / "straight"), last_checkpoint(folder_ / "halves"));
}

TEST_F(TrainerTest, WorkersAndTheCacheChangeNoBitAndMayChangeMeanwhile) {
  train("straight", 20);
  const auto train_with = [&](int64_t workers, const std::string& cache, int64_t steps) {
    TrainConfig config = tiny_config(folder_ / "data", steps);
    config.data.workers = workers;
    config.data.cache = cache;
    Trainer trainer(config, folder_ / "other");
    trainer.train();
  };
  train_with(0, "none", 7);
  train_with(5, (folder_ / "cache").string(), 20);
  EXPECT_EQ(last_checkpoint(folder_ / "straight"), last_checkpoint(folder_ / "other"));
  EXPECT_TRUE(fs::exists(folder_ / "data/.cache"));
  EXPECT_TRUE(fs::exists(folder_ / "cache"));
}

TEST_F(TrainerTest, TheSeedDecides) {
  train("a", 10);
  train("b", 10);
  train("c", 10, 2);
  EXPECT_EQ(last_checkpoint(folder_ / "a"), last_checkpoint(folder_ / "b"));
  EXPECT_NE(last_checkpoint(folder_ / "a"), last_checkpoint(folder_ / "c"));
}

TEST_F(TrainerTest, LearnsTheMeanThatTheTinyReferenceIs) {
  TrainConfig config = tiny_config(folder_ / "data", 150);
  config.optimizer.learning_rate = 0.01;
  Trainer trainer(config, folder_ / "run");
  trainer.train();
  std::ifstream csv(folder_ / "run/metrics.csv");
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line,
            "step,epoch,learning_rate,train_loss,seconds_per_step,validation_loss,relmse,smape,ssim,psnr");
  std::vector<double> losses;
  while (std::getline(csv, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (int i = 0; i < 4; ++i) std::getline(cells, cell, ',');
    losses.push_back(std::stod(cell));
  }
  ASSERT_EQ(losses.size(), 30u);
  EXPECT_LT(losses.back(), 0.5 * losses.front());
  EXPECT_LT(trainer.state().best_score, 1.0);
  EXPECT_TRUE(fs::exists(folder_ / "run/checkpoints/best/weights.safetensors"));
}

TEST_F(TrainerTest, KeepsOnlyTheLastAndTheBestCheckpoint) {
  train("run", 40);
  int folders = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "run/checkpoints"))
    if (entry.path().filename().string().rfind("step_", 0) == 0 && !entry.is_symlink()) ++folders;
  EXPECT_LE(folders, 2);
  EXPECT_EQ(fs::read_symlink(folder_ / "run/checkpoints/last"), "step_00000040");
}

TEST_F(TrainerTest, ARunFolderHoldsOneConfiguration) {
  train("run", 10);
  const std::string before = last_checkpoint(folder_ / "run");
  TrainConfig other = tiny_config(folder_ / "data", 10);
  other.optimizer.learning_rate = 0.1;
  try {
    Trainer trainer(other, folder_ / "run");
    FAIL() << "another configuration was accepted";
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("'learning_rate: 0.005', here 'learning_rate: 0.1'"),
              std::string::npos)
        << error.what();
  }
  EXPECT_EQ(last_checkpoint(folder_ / "run"), before);
}

TEST_F(TrainerTest, ADamagedCheckpointIsAnError) {
  train("run", 10);
  std::ofstream(folder_ / "run/checkpoints/last/weights.safetensors", std::ios::app) << "x";
  EXPECT_THROW(Trainer(tiny_config(folder_ / "data", 20), folder_ / "run"), Error);
}

TEST_F(TrainerTest, StepsWithoutFiniteGradientsAreSkippedAndAHopelessRunEnds) {
  Trainer trainer(tiny_config(folder_ / "data", 400), folder_ / "run");
  const std::vector<torch::Tensor> parameters = trainer.network().parameters();
  std::vector<torch::Tensor> before;
  {
    const torch::NoGradGuard no_graph;
    parameters[0].fill_(std::nan(""));  // every loss from here on is NaN
    for (const torch::Tensor& parameter : parameters) before.push_back(parameter.clone());
  }
  try {
    trainer.train();
    FAIL() << "a training without a finite loss went on to its end";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("diverged"), std::string::npos) << error.what();
  }
  EXPECT_EQ(trainer.state().optimizer_steps, 0);
  for (size_t i = 1; i < parameters.size(); ++i) EXPECT_TRUE(parameters[i].equal(before[i])) << i;
}

TEST(Schedule, FollowsItsFormulas) {
  OptimizerConfig config;
  config.learning_rate = 1;
  EXPECT_EQ(learning_rate(config, 500, 10, 1000), 1);
  config.schedule = "halve";
  config.halve_every = 10;
  EXPECT_EQ(learning_rate(config, 99, 10, 1000), 1);
  EXPECT_EQ(learning_rate(config, 100, 10, 1000), 0.5);
  EXPECT_EQ(learning_rate(config, 399, 10, 1000), 0.125);
  config.schedule = "cosine";
  EXPECT_NEAR(learning_rate(config, 500, 10, 1000), 0.5, 1e-9);
  EXPECT_NEAR(learning_rate(config, 999, 10, 1000), 0, 1e-5);
  config.warmup_steps = 4;
  EXPECT_NEAR(learning_rate(config, 0, 10, 1000000), 0.25, 1e-6);
}

TEST(EventLog, DropsTheRowsThatAResumedRunWritesAgain) {
  const TemporaryFolder folder;
  {
    EventLog log(folder / "m.csv", {"loss", "rate"}, 0);
    log.write(5, {{"loss", 0.5}});
    log.write(10, {{"loss", 0.25}, {"rate", 1e-3}});
    log.write(15, {{"rate", 1}});
  }
  EventLog log(folder / "m.csv", {"loss", "rate"}, 10);
  log.write(15, {{"loss", 0.125}});
  EXPECT_EQ(read_file(folder / "m.csv"), "step,loss,rate\n5,0.5,\n10,0.25,0.001\n15,0.125,\n");
}

}  // namespace
}  // namespace ld
