// A training that collapses is noticed and undone, bit for bit whatever happens meanwhile.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <sstream>

#include "core/log.h"
#include "tests/support/expect_error.h"
#include "tests/support/ranks.h"
#include "tests/training/tiny_training.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kCollapse = 33;  // steps done before the loss jumps
constexpr int64_t kFound = 45;     // windows of 5 steps, of which two in a row are raised

/// Losses that jump from 1 to 3 at kCollapse while the run went back fewer than `cured_after` times: a
/// function of the run's state alone, so that a run that continues meets what it met before.
struct Collapsing {
  explicit Collapsing(int64_t cured_after = 1) {
    options.loss = [this, cured_after, smape = make_loss("smape")](const torch::Tensor& denoised,
                                                                   const torch::Tensor& reference) {
      const torch::Tensor loss = smape(denoised, reference);
      if (trainer == nullptr) return loss;
      if (each_pass) each_pass(trainer->state());
      const bool bad = trainer->state().step >= kCollapse && trainer->state().rollbacks < cured_after;
      return loss + (bad ? 3 : 1);  // the loss itself falls to nothing in these few steps
    };
  }
  Collapsing(const Collapsing&) = delete;
  Collapsing& operator=(const Collapsing&) = delete;
  void train(const TrainConfig& config, const fs::path& run) {
    Trainer own(config, run, options);
    trainer = &own;
    const auto forget = [this](Trainer*) { trainer = nullptr; };
    const std::unique_ptr<Trainer, decltype(forget)> guard(&own, forget);
    own.train();
    state = own.state();
    weights = all_parameters(own.network()).clone();
  }

  TrainerOptions options;
  const Trainer* trainer = nullptr;
  std::function<void(const TrainingState&)> each_pass;
  TrainingState state;  // at the end
  torch::Tensor weights;
};

class Collapse : public ::testing::Test {
 protected:
  void SetUp() override { write_tiny_dataset(folder_ / "data", 4); }
  TrainConfig config(int64_t steps) const {
    TrainConfig config = tiny_config(folder_ / "data", steps);
    config.optimizer.ema = 0.9;
    config.watch.window = 5;
    config.watch.patience = 2;
    return config;
  }
  std::vector<std::vector<std::string>> rows(const std::string& run) const {
    std::istringstream lines(read_file(folder_ / run / "metrics.csv"));
    std::vector<std::vector<std::string>> rows;
    std::string line;
    while (std::getline(lines, line)) {
      std::istringstream cells(line);
      rows.emplace_back();
      for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
    }
    return rows;
  }
  std::string log(const std::string& run) const {
    spdlog::default_logger()->flush();
    return read_file(folder_ / run / "train.log");
  }
  void expect_same(const std::string& a, const std::string& b) const {
    EXPECT_EQ(last_checkpoint(folder_ / a), last_checkpoint(folder_ / b));
    EXPECT_EQ(read_file(folder_ / a / "metrics.csv"), read_file(folder_ / b / "metrics.csv"));
  }
  TemporaryFolder folder_;
};

TEST_F(Collapse, GoesBackToTheBestAtHalfTheRate) {
  Collapsing collapsing;
  int64_t highest = 0, lowest_after = 1000;
  collapsing.each_pass = [&](const TrainingState& state) {
    if (state.rollbacks == 0)
      highest = std::max(highest, state.step);
    else
      lowest_after = std::min(lowest_after, state.step);
  };
  collapsing.train(config(60), folder_ / "run");
  EXPECT_EQ(collapsing.state.step, 60);
  EXPECT_EQ(collapsing.state.rollbacks, 1);
  EXPECT_EQ(highest, kFound - 1);
  EXPECT_TRUE(lowest_after == 10 || lowest_after == 20 || lowest_after == 30) << lowest_after;

  const auto table = rows("run");
  ASSERT_EQ(table.size(), 1u + 12);  // each step once
  EXPECT_EQ(table[0][10], "rollbacks");
  for (size_t i = 1; i < table.size(); ++i) {
    const int64_t step = std::stoll(table[i][0]);
    EXPECT_EQ(step, static_cast<int64_t>(5 * i));
    const bool after = step > lowest_after;
    EXPECT_EQ(table[i][10], after ? "1" : "0");
    EXPECT_NEAR(std::stod(table[i][2]), after ? 0.0025 : 0.005, 1e-4);
  }
  const std::string text = log("run");
  EXPECT_NE(text.find("collapsed by step 45"), std::string::npos) << text;
  EXPECT_NE(text.find("with 0.5 of the learning rate (1 of 3 times)"), std::string::npos) << text;
}

TEST_F(Collapse, StoppedOrKilledAnywhereItEndsWithTheSameBits) {
  Collapsing straight;
  straight.train(config(60), folder_ / "straight");
  ASSERT_EQ(straight.state.rollbacks, 1);
  // Stopped while the loss is raised but nothing is found yet; after going back; and killed (a copy of the
  // folder is what the killed one leaves) before the run that went back saved anything.
  for (const int64_t stop : {40, 50}) {
    const std::string run = "stopped_" + std::to_string(stop);
    Collapsing first, second;
    first.train(config(stop), folder_ / run);
    EXPECT_EQ(first.state.rollbacks, stop > kFound ? 1 : 0);
    EXPECT_EQ(first.state.watch.raised, stop > kFound ? 0 : 1);
    second.train(config(60), folder_ / run);
    expect_same("straight", run);
  }
  Collapsing killed, continued;
  int passes = 0;
  killed.each_pass = [&](const TrainingState& state) {
    if (state.rollbacks == 1 && ++passes == 3)
      fs::copy(folder_ / "killed", folder_ / "left",
               fs::copy_options::recursive | fs::copy_options::copy_symlinks);
  };
  killed.train(config(60), folder_ / "killed");
  EXPECT_FALSE(fs::exists(folder_ / "left/checkpoints/step_00000040"));
  continued.train(config(60), folder_ / "left");
  expect_same("straight", "left");
}

TEST_F(Collapse, BeforeTheFirstCheckpointItBeginsAnew) {
  TrainConfig late = config(60);
  late.run.validate_every = late.run.checkpoint_every = 1000;
  Collapsing collapsing;
  collapsing.train(late, folder_ / "run");
  EXPECT_EQ(collapsing.state.rollbacks, 1);
  late.optimizer.learning_rate /= 2;
  Trainer slower(late, folder_ / "slower");
  slower.train();
  EXPECT_TRUE(collapsing.weights.equal(all_parameters(slower.network())));
  EXPECT_EQ(read_file(folder_ / "run/checkpoints/last/optimizer.safetensors"),
            read_file(folder_ / "slower/checkpoints/last/optimizer.safetensors"));
}

TEST_F(Collapse, WithoutABestItGoesBackToBeforeTheRise) {
  TrainConfig unvalidated = config(60);
  unvalidated.run.validate_every = 1000;
  unvalidated.run.keep = 10;
  Collapsing collapsing;
  collapsing.train(unvalidated, folder_ / "run");
  EXPECT_EQ(collapsing.state.rollbacks, 1);
  EXPECT_NE(log("run").find("Going back to step 30"), std::string::npos) << log("run");
}

TEST_F(Collapse, AfterTheRetriesTheRunEndsWithAdvice) {
  for (int start = 0; start < 2; ++start) {  // the same again
    Collapsing collapsing(1000);
    const std::string text = error_text([&] { collapsing.train(config(60), folder_ / "run"); });
    for (const char* part : {"collapsed by step 45", "gone back 3 times", "0.125 of the learning rate",
                             "lower optimizer.learning_rate", "optimizer.clip_norm", "seed"})
      EXPECT_NE(text.find(part), std::string::npos) << "no '" << part << "' in " << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    const fs::path checkpoints = folder_ / "run/checkpoints";
    EXPECT_EQ(fs::read_symlink(checkpoints / "last"), fs::read_symlink(checkpoints / "best"));
    EXPECT_FALSE(fs::exists(checkpoints / "step_00000040")) << "it is collapsed";
  }
  // The section may change: a run may go on regardless.
  TrainConfig unwatched = config(60);
  unwatched.watch.enabled = false;
  Collapsing regardless(1000);
  regardless.train(unwatched, folder_ / "run");
  EXPECT_EQ(regardless.state.step, 60);
}

TEST_F(Collapse, WatchingChangesNoBitWhereNothingCollapses) {
  TrainConfig unwatched = config(60);
  unwatched.watch.enabled = false;
  Trainer(config(60), folder_ / "watched").train();
  Trainer(unwatched, folder_ / "unwatched").train();
  for (const char* name : {"weights.safetensors", "optimizer.safetensors"})
    EXPECT_EQ(read_file(folder_ / "watched/checkpoints/last" / name),
              read_file(folder_ / "unwatched/checkpoints/last" / name));
  EXPECT_EQ(read_file(folder_ / "watched/metrics.csv"), read_file(folder_ / "unwatched/metrics.csv"));
}

TEST_F(Collapse, KernelsOfOneTapAreOneToo) {
  Collapsing collapsing;  // validation losses, too, so that no validation after it is the best
  collapsing.options.kernel_probe = [&](Network& network, const NetworkInput& input) {
    EXPECT_FALSE(torch::GradMode::is_enabled());
    check_input(input, network.config());
    const TrainingState& state = collapsing.trainer->state();
    const bool one_tap = state.step >= kCollapse && state.rollbacks == 0;
    return KernelStatistics{one_tap ? 0.01 : 2.0, one_tap ? 0.99 : 0.25, {0.75, 0.25}};
  };
  TrainConfig kernels = config(60);
  kernels.watch.loss_factor = 100;
  kernels.watch.entropy = 0.1;
  collapsing.train(kernels, folder_ / "run");
  EXPECT_EQ(collapsing.state.rollbacks, 1);
  EXPECT_NE(log("run").find("collapsed by step 40: the kernels' mean entropy is 0.01 nats"),
            std::string::npos)
      << log("run");
  const auto table = rows("run");
  EXPECT_EQ(table[0][11], "kernel_entropy");
  for (size_t i = 1; i < table.size(); ++i) {
    const bool validated = std::stoll(table[i][0]) % 10 == 0;
    EXPECT_EQ(table[i].size(), validated ? 15u : 14u) << i;  // getline() drops the last empty one
    if (validated) {
      EXPECT_EQ((std::vector<std::string>(table[i].begin() + 11, table[i].end())),
                (std::vector<std::string>{"2", "0.25", "0.75", "0.25"}));
    }
  }
}

TEST_F(Collapse, KernelsThatAreTheSameEverywhereAreNeverTheBest) {
  Collapsing collapsing(0);
  std::vector<int64_t> validated;
  collapsing.options.kernel_probe = [&](Network&, const NetworkInput&) {
    const TrainingState& state = collapsing.trainer->state();
    validated.push_back(state.step);
    return KernelStatistics{2.0, 0.25, {0.75, 0.25}, state.rollbacks == 0 ? 1e-6 : 0.1};
  };
  collapsing.train(config(20), folder_ / "run");
  // The first validation, the best so far, is not kept: the run begins anew.
  EXPECT_EQ(validated, (std::vector<int64_t>{10, 10, 20}));
  EXPECT_EQ(collapsing.state.rollbacks, 1);
  EXPECT_NE(
      log("run").find("all pixels have the same kernel (relative deviation 1e-06): nothing is learnt any "
                      "more. Going back to step 0, with 0.5 of the learning rate (1 of 3 times)"),
      std::string::npos)
      << log("run");
}

TEST_F(Collapse, KernelsThatAreNotGeneratedAreNotJudged) {
  for (const std::string& name : network_names()) {
    if (network_traits(name).filter != Filter::own) continue;
    Collapsing collapsing(0);
    collapsing.options.kernel_probe = [](Network&, const NetworkInput&) {
      return KernelStatistics{0, 1, {}, 0};  // one tap, the same everywhere
    };
    TrainConfig changed = config(20);
    changed.network.name = name;
    collapsing.train(changed, folder_ / name);
    EXPECT_EQ(collapsing.state.rollbacks, 0) << name;
    EXPECT_EQ(collapsing.state.step, 20) << name;
  }
}

TEST_F(Collapse, TwoProcessesGoBackTogether) {
  std::vector<TrainingState> states(2);
  std::vector<torch::Tensor> weights(2);
  run_ranks(2, [&](std::unique_ptr<ProcessGroup> group) {
    const auto rank = static_cast<size_t>(group->rank());
    Collapsing collapsing;
    collapsing.options.group = group.get();
    collapsing.train(config(60), folder_ / (group->is_root() ? "run" : "elsewhere"));
    states[rank] = collapsing.state;
    weights[rank] = collapsing.weights;
  });
  EXPECT_EQ(states[0].rollbacks, 1);
  EXPECT_EQ(state_to_json(states[0]), state_to_json(states[1]));
  EXPECT_TRUE(weights[0].equal(weights[1]));
}

}  // namespace
}  // namespace ld
