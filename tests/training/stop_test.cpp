// SIGTERM at any point of a training: at most one step more, saved, 143; and it goes on as if nothing had
// been. The training runs in a process of its own, which leaves with its exit code.
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <iostream>
#include <optional>

#include "core/signals.h"
#include "tests/training/tiny_training.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// SIGTERM in pass `number` (from 1) of those with or those without gradients; the two passes that are timed
/// before the first step count.
TrainerOptions terminated_in_pass(int number, bool with_gradients) {
  TrainerOptions options;
  options.loss = [=, passes = std::make_shared<int>(0), smape = make_loss("smape")](
                     const torch::Tensor& denoised, const torch::Tensor& reference) {
    if (torch::GradMode::is_enabled() == with_gradients && ++*passes == number) std::raise(SIGTERM);
    return smape(denoised, reference);
  };
  return options;
}

/// Trains until the signal; exit code 143 when the run is then at `step` and saved there.
[[noreturn]] void train_until_stopped(const TrainConfig& config, const fs::path& run,
                                      const TrainerOptions& options, int64_t step) {
  install_stop_handler();
  Trainer trainer(config, run, options);
  trainer.train();
  const bool saved = CheckpointFolder(run, 2).holds(trainer.state().step);
  const bool as_expected = trainer.state().step == step && saved == (step > 0);
  if (!as_expected) std::cerr << "at step " << trainer.state().step << " of an expected " << step << "\n";
  std::_Exit(as_expected ? stop_exit_code() : 1);  // no destructors: the folder is the other process's
}

class Stop : public ::testing::Test {
 protected:
  /// The process that trains starts this program and this case anew and finds the folder of the first one.
  Stop() {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    const char* folder = std::getenv("LD_STOP_TEST");
    if (folder == nullptr) {
      own_.emplace();
      write_tiny_dataset(*own_ / "data", 4);
      setenv("LD_STOP_TEST", own_->path().c_str(), 1);
    }
    folder_ = own_ ? own_->path() : fs::path(folder);
  }
  ~Stop() override {
    if (own_) unsetenv("LD_STOP_TEST");
  }
  TrainConfig config() const {
    TrainConfig config = tiny_config(folder_ / "data", 20);
    config.optimizer.ema = 0.9;
    return config;
  }
  void expect_same_as_undisturbed(const TrainConfig& config) const {
    for (const char* run : {"run", "straight"}) Trainer(config, folder_ / run).train();
    EXPECT_EQ(last_checkpoint(folder_ / "run"), last_checkpoint(folder_ / "straight"));
    EXPECT_EQ(read_file(folder_ / "run/metrics.csv"), read_file(folder_ / "straight/metrics.csv"));
  }

  std::optional<TemporaryFolder> own_;
  fs::path folder_;
};

TEST_F(Stop, DuringAStep) {
  EXPECT_EXIT(train_until_stopped(config(), folder_ / "run", terminated_in_pass(2 + 6, true), 6),
              ::testing::ExitedWithCode(143), "");
  expect_same_as_undisturbed(config());
}

TEST_F(Stop, BeforeTheFirstStep) {
  EXPECT_EXIT(train_until_stopped(config(), folder_ / "run", terminated_in_pass(1, true), 0),
              ::testing::ExitedWithCode(143), "");
}

TEST_F(Stop, WhileTheLearningRateRises) {
  TrainConfig rising = config();
  rising.optimizer.warmup_steps = 10;
  EXPECT_EXIT(train_until_stopped(rising, folder_ / "run", terminated_in_pass(2 + 3, true), 3),
              ::testing::ExitedWithCode(143), "");
}

TEST_F(Stop, WithinAStepOfSeveralBatches) {
  TrainConfig several = config();
  several.optimizer.accumulate = 3;
  EXPECT_EXIT(train_until_stopped(several, folder_ / "run", terminated_in_pass(2 + 4, true), 2),
              ::testing::ExitedWithCode(143), "");
  expect_same_as_undisturbed(several);
}

TEST_F(Stop, DuringValidationBetweenFrames) {
  // Two data sets, so two validation frames.
  TrainConfig two = config();
  two.data.path.clear();
  two.data.paths = {{(folder_ / "data").string(), 1}, {(folder_ / "more").string(), 1}};
  if (own_) write_tiny_dataset(folder_ / "more", 2);
  EXPECT_EXIT(train_until_stopped(two, folder_ / "run", terminated_in_pass(1, false), 10),
              ::testing::ExitedWithCode(143), "");
  const auto rows_before = read_file(folder_ / "run/metrics.csv");
  EXPECT_EQ(rows_before.find("\n10,"), std::string::npos) << "half a validation is none";
  expect_same_as_undisturbed(two);
}

}  // namespace
}  // namespace ld
