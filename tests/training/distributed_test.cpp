// Two ranks that train together: as one process does, to rounding; and stopped and continued, bit for bit.
// Rank 1 sees another folder than rank 0, as on a machine without the same disk.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "tests/support/expect_error.h"
#include "tests/support/ranks.h"
#include "tests/training/tiny_training.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

struct Mode {
  std::string name;
  void (*set)(TrainConfig&);
};

std::ostream& operator<<(std::ostream& out, const Mode& mode) {
  return out << mode.name;
}

class Distributed : public ::testing::Test {
 protected:
  void SetUp() override { write_tiny_dataset(folder_ / "data", 6); }

  TrainConfig config(int64_t steps) const {
    TrainConfig config = tiny_config(folder_ / "data", steps);
    config.data.batch = 3;  // which two processes share as 1 and 2
    config.epochs = 10;
    config.run.log_every = 1;
    config.run.validate_every = config.run.checkpoint_every = 6;  // also where a half ends
    return config;
  }

  void train(const std::string& run, const TrainConfig& config, int processes) {
    run_ranks(processes, [&](std::unique_ptr<ProcessGroup> group) {
      Trainer trainer(config, folder_ / (group->is_root() ? run : "elsewhere"), {group.get(), "", {}, {}});
      trainer.train();
      EXPECT_EQ(trainer.state().step, std::min(config.run.max_steps, trainer.total_steps()));
    });
  }

  /// One column of metrics.csv.
  std::vector<double> column(const std::string& run, const std::string& name) {
    std::istringstream lines(read_file(folder_ / run / "metrics.csv"));
    std::string line;
    std::vector<double> values;
    int wanted = -1;
    while (std::getline(lines, line)) {
      std::istringstream cells(line);
      std::string cell;
      for (int i = 0; std::getline(cells, cell, ','); ++i) {
        if (wanted < 0 && cell == name)
          wanted = i;
        else if (i == wanted && cell != name && !cell.empty())
          values.push_back(std::stod(cell));
      }
    }
    return values;
  }

  TemporaryFolder folder_;
};

class DistributedResume : public Distributed, public ::testing::WithParamInterface<Mode> {};

TEST_P(DistributedResume, TwoHalvesAreTheWhole) {
  const auto of = [&](int64_t steps) {
    TrainConfig result = config(steps);
    GetParam().set(result);
    return result;
  };
  train("straight", of(12), 2);
  train("halves", of(6), 2);
  train("halves", of(12), 2);
  EXPECT_EQ(last_checkpoint(folder_ / "straight"), last_checkpoint(folder_ / "halves"));
  EXPECT_EQ(read_file(folder_ / "straight/metrics.csv"), read_file(folder_ / "halves/metrics.csv"));
  EXPECT_FALSE(fs::exists(folder_ / "elsewhere/checkpoints")) << "rank 0 alone writes";
}

INSTANTIATE_TEST_SUITE_P(Modes, DistributedResume,
                         ::testing::Values(Mode{"constant",
                                                [](TrainConfig& c) { c.optimizer.schedule = "constant"; }},
                                           Mode{"step_accumulate",
                                                [](TrainConfig& c) {
                                                  c.optimizer.schedule = "step";
                                                  c.optimizer.step_epochs = 3;
                                                  c.optimizer.accumulate = 2;
                                                  c.epochs = 20;
                                                }},
                                           Mode{"drawn_samples",
                                                [](TrainConfig& c) {
                                                  c.data.samples = {1, 2};
                                                }},
                                           Mode{"cosine_ema", [](TrainConfig& c) { c.optimizer.ema = 0.95; }},
                                           Mode{"one_cycle_ema",
                                                [](TrainConfig& c) {
                                                  c.optimizer.schedule = "one_cycle";
                                                  c.optimizer.ema = 0.9;
                                                }}),
                         [](const auto& test) { return test.param.name; });

TEST_F(Distributed, LossesAndScoresFollowThoseOfOneProcess) {
  TrainConfig settings = config(12);
  settings.run.validate_every = 4;
  train("one", settings, 1);
  train("two", settings, 2);
  for (const char* name : {"train_loss", "validation_loss", "psnr"}) {
    const std::vector<double> one = column("one", name), two = column("two", name);
    ASSERT_EQ(one.size(), two.size()) << name;
    ASSERT_GE(one.size(), 3u) << name;
    // Twelve steps of Adam carry the rounding of the first on.
    for (size_t i = 0; i < one.size(); ++i) EXPECT_NEAR(two[i] / one[i], 1, 1e-3) << name << " " << i;
    EXPECT_NEAR(two[0] / one[0], 1, name == std::string("train_loss") ? 2e-6 : 1e-3) << name;
  }
}

TEST_F(Distributed, ANanOnOneRankIsSkippedByAll) {
  constexpr int kBad = 5;
  std::vector<torch::Tensor> weights(2);
  run_ranks(2, [&](std::unique_ptr<ProcessGroup> group) {
    TrainerOptions options;
    options.group = group.get();
    const bool bad_rank = group->rank() == 1;
    options.loss = [=, passes = std::make_shared<int>(0), smape = make_loss("smape")](
                       const torch::Tensor& denoised, const torch::Tensor& reference) {
      const torch::Tensor loss = smape(denoised, reference);
      if (!torch::GradMode::is_enabled()) return loss;
      const bool bad = bad_rank && ++*passes == kBad;
      return bad ? loss * std::numeric_limits<double>::quiet_NaN() : loss;
    };
    Trainer trainer(config(8), folder_ / (group->is_root() ? "run" : "elsewhere"), options);
    trainer.train();
    EXPECT_EQ(trainer.state().step, 8);
    EXPECT_EQ(trainer.state().skipped, 1);
    EXPECT_EQ(trainer.state().optimizer_steps, 7);
    weights[static_cast<size_t>(group->rank())] = all_parameters(trainer.network()).clone();
  });
  EXPECT_TRUE(weights[0].isfinite().all().item<bool>());
  EXPECT_TRUE(weights[0].equal(weights[1]));
}

TEST_F(Distributed, RankZeroSaysHowManyStepsThereIsTimeFor) {
  TrainConfig settings = config(6);
  settings.run.minutes = 0.05;
  std::vector<int64_t> steps(2);
  for (int start = 0; start < 2; ++start) {  // the second one continues
    settings.run.max_steps += start;
    run_ranks(2, [&](std::unique_ptr<ProcessGroup> group) {
      Trainer trainer(settings, folder_ / (group->is_root() ? "run" : "elsewhere"),
                      {group.get(), "", {}, {}});
      int64_t& own = steps[static_cast<size_t>(group->rank())];
      if (start == 1) {
        EXPECT_EQ(trainer.total_steps(), own);
      }
      own = trainer.total_steps();
      trainer.train();
    });
    EXPECT_GT(steps[0], 6);
    EXPECT_EQ(steps[0], steps[1]);
  }
}

TEST_F(Distributed, DifferentConfigurationsAreRefusedByAll) {
  run_ranks(2, [&](std::unique_ptr<ProcessGroup> group) {
    TrainConfig other = config(8);
    if (group->rank() == 1) other.optimizer.learning_rate = 0.25;
    EXPECT_ERROR(Trainer(other, folder_ / "run", {group.get(), "", {}, {}}), "rank 1: another configuration");
    EXPECT_FALSE(fs::exists(folder_ / "run"));
    TrainConfig too_small = config(8);
    too_small.data.batch = 1;
    EXPECT_ERROR(Trainer(too_small, folder_ / "run", {group.get(), "", {}, {}}),
                 "cannot be split over 2 processes");
  });
}

}  // namespace
}  // namespace ld
