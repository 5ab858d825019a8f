#include "training/trainer.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <chrono>
#include <fstream>
#include <thread>

#include "core/log.h"
#include "tests/support/expect_error.h"
#include "tests/support/full_disk.h"
#include "tests/training/tiny_training.h"
#include "training/estimate.h"
#include "weights/model_file.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

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

TEST_F(TrainerTest, WorkersAndTheCacheChangeNoBitAndMayChangeMeanwhile) {
  train("straight", 20);
  const auto train_with = [&](int64_t workers, const std::string& cache, int64_t steps) {
    TrainConfig config = tiny_config(folder_ / "data", steps);
    config.data.workers = workers;
    config.data.cache = cache;
    Trainer trainer(config, folder_ / "other");
    trainer.train();
  };
  train_with(0, "none", 10);
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
            "step,epoch,learning_rate,train_loss,skipped,validation_loss,relmse,smape,ssim,psnr,rollbacks,"
            "kernel_entropy,kernel_centre_share,kernel_layer_share_1,kernel_layer_share_2");
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
  EXPECT_TRUE(fs::exists(folder_ / "run/timing.csv"));
  EXPECT_TRUE(fs::exists(folder_ / "run/train.log"));
  EXPECT_FALSE(fs::is_empty(folder_ / "run/tensorboard"));
  const auto json = nlohmann::json::parse(read_file(folder_ / "run/run.json"));
  EXPECT_EQ(json.at("total_steps"), 2000);
  EXPECT_EQ(json.at("libtorch"), TORCH_VERSION);
}

TEST_F(TrainerTest, ARunFolderHoldsOneConfiguration) {
  train("run", 10);
  const std::string before = last_checkpoint(folder_ / "run");
  TrainConfig other = tiny_config(folder_ / "data", 10);
  other.optimizer.learning_rate = 0.1;
  EXPECT_ERROR(Trainer(other, folder_ / "run"), "'learning_rate: 0.005', here 'learning_rate: 0.1'");
  other = tiny_config(folder_ / "data", 10);
  other.data.batch = 4;
  EXPECT_ERROR(Trainer(other, folder_ / "run"), "takes 2 crops a step, but data.batch=4");
  EXPECT_EQ(last_checkpoint(folder_ / "run"), before);
}

TEST_F(TrainerTest, ARunFolderIsTrainedIntoByOneAtATime) {
  const TrainConfig config = tiny_config(folder_ / "data", 10);
  Trainer first(config, folder_ / "run");
  EXPECT_ERROR(Trainer(config, folder_ / "run"), "another ld_train is training into this run folder");
  first.train();
  Trainer second(config, folder_ / "run");
  EXPECT_EQ(second.state().step, 10);
}

TEST_F(TrainerTest, ABatchMayBeDividedAnew) {
  train("run", 10);
  TrainConfig other = tiny_config(folder_ / "data", 20);
  other.data.batch = 1;
  other.optimizer.accumulate = 2;
  Trainer trainer(other, folder_ / "run");
  trainer.train();
  EXPECT_EQ(trainer.state().step, 20);
}

TEST_F(TrainerTest, ADamagedCheckpointFallsBackToTheOneBefore) {
  train("straight", 40);
  train("run", 30);
  std::ofstream(folder_ / "run/checkpoints/last/weights.safetensors", std::ios::app) << "x";
  train("run", 40);
  EXPECT_EQ(last_checkpoint(folder_ / "straight"), last_checkpoint(folder_ / "run"));
  EXPECT_EQ(read_file(folder_ / "straight/metrics.csv"), read_file(folder_ / "run/metrics.csv"));
  spdlog::default_logger()->flush();
  const std::string log = read_file(folder_ / "run/train.log");
  EXPECT_NE(log.find("checkpoint step_00000030 is damaged"), std::string::npos) << log;
  EXPECT_NE(log.find("falling back to checkpoint step_00000020"), std::string::npos);
}

TEST_F(TrainerTest, NoWholeCheckpointIsAnErrorAndNoNewBeginning) {
  train("run", 10);
  std::ofstream(folder_ / "run/checkpoints/last/weights.safetensors", std::ios::app) << "x";
  EXPECT_ERROR(Trainer(tiny_config(folder_ / "data", 20), folder_ / "run"), "no checkpoint is whole");
}

TEST_F(TrainerTest, AFullDiskIsReportedAndTheRunGoesOn) {
  train("straight", 40);
  int passes = 0;
  std::unique_ptr<FileSizeLimit> full;
  TrainerOptions options;
  options.loss = [&, smape = make_loss("smape")](const torch::Tensor& denoised,
                                                 const torch::Tensor& reference) {
    if (torch::GradMode::is_enabled()) ++passes;  // two before the first step
    if (passes == 2 + 15) full = std::make_unique<FileSizeLimit>(1);
    if (passes == 2 + 35) full.reset();
    return smape(denoised, reference);
  };
  Trainer trainer(tiny_config(folder_ / "data", 40), folder_ / "run", options);
  trainer.train();
  EXPECT_EQ(last_checkpoint(folder_ / "straight"), last_checkpoint(folder_ / "run"));
  EXPECT_EQ(read_file(folder_ / "straight/metrics.csv"), read_file(folder_ / "run/metrics.csv"));
  EXPECT_TRUE(fs::exists(folder_ / "run/checkpoints/step_00000010"));
  EXPECT_FALSE(fs::exists(folder_ / "run/checkpoints/step_00000030"));
}

TEST_F(TrainerTest, ADiskThatStaysFullIsAnErrorAtTheEnd) {
  train("straight", 20);
  train("run", 10);
  {
    Trainer trainer(tiny_config(folder_ / "data", 20), folder_ / "run");
    const FileSizeLimit full(1);
    EXPECT_ERROR(trainer.train(), "steps 11 to 20 are lost");
  }
  train("run", 20);
  EXPECT_EQ(last_checkpoint(folder_ / "straight"), last_checkpoint(folder_ / "run"));
}

TEST_F(TrainerTest, TheTimeBudgetStopsAndSaves) {
  TrainConfig config = tiny_config(folder_ / "data", 0);
  config.run.max_minutes = 1.0 / 60;
  Trainer trainer(config, folder_ / "run");
  trainer.train();
  EXPECT_GT(trainer.state().step, 0);
  EXPECT_LT(trainer.state().step, trainer.total_steps());
  Trainer again(config, folder_ / "run");
  EXPECT_EQ(again.state().step, trainer.state().step);
}

TEST_F(TrainerTest, TheScheduleEndsWhenTheTimeDoes) {
  TrainConfig config = tiny_config(folder_ / "data", 0);
  config.run.minutes = 0.1;
  config.run.validate_every = config.run.checkpoint_every = 100;
  const auto start = std::chrono::steady_clock::now();
  Trainer trainer(config, folder_ / "run");
  const int64_t steps = trainer.total_steps();
  EXPECT_GT(steps, 10);
  trainer.train();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_GT(seconds, 1.5);  // 6, on a machine that does nothing else
  EXPECT_LT(seconds, 24);
  EXPECT_EQ(trainer.state().step, steps);
  EXPECT_NE(read_file(folder_ / "run/config.yaml").find("\nsteps: " + std::to_string(steps) + "\n"),
            std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(read_file(folder_ / "run/run.json")).at("total_steps"), steps);
}

TEST_F(TrainerTest, TheNumberOfStepsIsMeasuredOnce) {
  TrainConfig config = tiny_config(folder_ / "data", 10);
  config.optimizer.schedule = "one_cycle";
  config.run.minutes = 0.05;
  int64_t steps = 0;
  {
    Trainer killed_before_the_first_step(config, folder_ / "halves");
    steps = killed_before_the_first_step.total_steps();
  }
  TrainerOptions slower;
  slower.loss = [smape = make_loss("smape")](const torch::Tensor& denoised, const torch::Tensor& reference) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return smape(denoised, reference);
  };
  Trainer(config, folder_ / "halves").train();
  config.run.max_steps = 30;
  Trainer second(config, folder_ / "halves", slower);
  EXPECT_EQ(second.total_steps(), steps);
  second.train();
  // The line of run.json that does the run again reads the stored configuration, and measures nothing.
  auto stored = config_from_tree<TrainConfig>(read_config(folder_ / "halves/config.yaml"));
  Trainer straight(stored, folder_ / "straight", slower);
  EXPECT_EQ(straight.total_steps(), steps);
  straight.train();
  EXPECT_EQ(last_checkpoint(folder_ / "straight"), last_checkpoint(folder_ / "halves"));
  EXPECT_EQ(read_file(folder_ / "straight/metrics.csv"), read_file(folder_ / "halves/metrics.csv"));
  config.run.minutes = 1;
  EXPECT_ERROR(Trainer(config, folder_ / "halves"), "there 'minutes: 0.05', here 'minutes: 1'");
}

TEST_F(TrainerTest, MeasuringTheSpeedLeavesNoTrace) {
  TrainConfig config = tiny_config(folder_ / "data", 10);
  config.run.minutes = 0.05;
  Trainer measured(config, folder_ / "measured");
  config.run.minutes = 0;
  config.steps = measured.total_steps();
  Trainer told(config, folder_ / "told");
  EXPECT_TRUE(all_parameters(measured.network()).equal(all_parameters(told.network())));
  measured.train();
  told.train();
  EXPECT_EQ(last_checkpoint(folder_ / "measured"), last_checkpoint(folder_ / "told"));
  EXPECT_EQ(read_file(folder_ / "measured/metrics.csv"), read_file(folder_ / "told/metrics.csv"));
  EXPECT_FALSE(fs::exists(folder_ / "measured/.pace.partial"));
}

TEST_F(TrainerTest, AveragedWeightsValidateAndAreSaved) {
  TrainConfig config = tiny_config(folder_ / "data", 10);
  config.optimizer.ema = 0.9;
  Trainer trainer(config, folder_ / "run");
  trainer.train();
  const torch::Tensor average = all_parameters(trainer.averaged_network());
  EXPECT_FALSE(average.equal(all_parameters(trainer.network())));
  EXPECT_TRUE(average.equal(all_parameters(*load_network(folder_ / "run"))));
}

TEST(Estimate, SaysTimeMemoryAndDisk) {
  Plan plan;
  plan.batch = {0.5, 700};
  plan.validation = {1e-6, 600};
  plan.accumulate = 2;
  plan.steps = 3600;
  plan.validation_pixels = 1000000;
  plan.validations = 100;
  plan.state_megabytes = 30;
  plan.checkpoint_bytes = 30000000;
  plan.checkpoints = 4;
  plan.free_bytes = 100000000;
  EXPECT_EQ(time_text(plan), "estimate: 3600 steps of 1 s and 100 validations: 1h01m; memory 730 MB");
  plan.validation.megabytes = 5000;
  EXPECT_NE(time_text(plan).find("memory 5030 MB when validating"), std::string::npos) << time_text(plan);
  EXPECT_TRUE(fits_in_memory(plan)) << "as far as is known";
  plan.available_megabytes = 5029;
  EXPECT_FALSE(fits_in_memory(plan));
  plan.available_megabytes = 5030;
  EXPECT_TRUE(fits_in_memory(plan));
  plan.max_minutes = 37;
  EXPECT_NE(time_text(plan).find("run.max_minutes=37 ends it after about 2160 steps"), std::string::npos)
      << time_text(plan);
  EXPECT_EQ(disk_text(plan), "estimate: up to 4 checkpoints of 30.0 MB: 120.0 MB of the 100 MB free");
  EXPECT_FALSE(fits_on_disk(plan));
}

}  // namespace
}  // namespace ld
