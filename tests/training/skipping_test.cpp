// Losses and gradients that are not finite never reach weights, moments or averages.
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/expect_error.h"
#include "tests/training/tiny_training.h"
#include "weights/model_file.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What goes wrong with a loss, given the denoised image.
struct Fault {
  std::string name;
  torch::Tensor (*apply)(const torch::Tensor& loss, const torch::Tensor& denoised);
};

std::ostream& operator<<(std::ostream& out, const Fault& fault) {
  return out << fault.name;
}

/// 0, with a derivative of `slope` times infinity.
torch::Tensor steep_zero(const torch::Tensor& denoised, double slope) {
  return ((denoised - denoised.detach()) * slope).sqrt().sum();
}

/// SMAPE with the fault in the steps `from` to `to` (from 1) of a run of one batch a step. Two passes come
/// before the first step of a program.
TrainerOptions faulty(const Fault& fault, int from, int to) {
  TrainerOptions options;
  options.loss = [=, passes = std::make_shared<int>(-2), smape = make_loss("smape")](
                     const torch::Tensor& denoised, const torch::Tensor& reference) {
    const torch::Tensor loss = smape(denoised, reference);
    if (!torch::GradMode::is_enabled()) return loss;
    ++*passes;
    return *passes >= from && *passes <= to ? fault.apply(loss, denoised) : loss;
  };
  return options;
}

class Skipped : public ::testing::Test {
 protected:
  void SetUp() override { write_tiny_dataset(folder_ / "data", 4); }
  TrainConfig config(int64_t steps) const {
    TrainConfig config = tiny_config(folder_ / "data", steps);
    config.optimizer.ema = 0.9;
    config.run.max_skipped = 3;
    return config;
  }
  TemporaryFolder folder_;
};

class Skipping : public Skipped, public ::testing::WithParamInterface<Fault> {};

TEST_P(Skipping, LeavesEveryBitAsItWas) {
  Trainer before(config(7), folder_ / "before");
  before.train();
  Trainer after(config(8), folder_ / "after", faulty(GetParam(), 8, 8));
  after.train();
  EXPECT_EQ(after.state().step, 8);
  EXPECT_EQ(after.state().optimizer_steps, 7);
  EXPECT_EQ(after.state().skipped, 1);
  EXPECT_TRUE(all_parameters(before.network()).equal(all_parameters(after.network())));
  EXPECT_TRUE(all_parameters(before.averaged_network()).equal(all_parameters(after.averaged_network())));
  // Weights, moments and averages as the files hold them.
  for (const char* name : {"weights.safetensors", "optimizer.safetensors"}) {
    const SafetensorsFile a(folder_ / "before/checkpoints/last" / name),
        b(folder_ / "after/checkpoints/last" / name);
    ASSERT_EQ(a.tensors().size(), b.tensors().size());
    for (const TensorView& tensor : a.tensors())
      EXPECT_TRUE(read_tensor(tensor).equal(read_tensor(b.tensor(tensor.name)))) << tensor.name;
  }
  // The run goes on from there, and its table counts the step.
  Trainer more(config(20), folder_ / "after");
  more.train();
  EXPECT_EQ(more.state().optimizer_steps, 19);
  EXPECT_TRUE(all_parameters(more.network()).isfinite().all().item<bool>());
  const std::string table = read_file(folder_ / "after/metrics.csv");
  EXPECT_EQ(table.find("nan"), std::string::npos) << table;
  EXPECT_NE(table.find("\n20,10,"), std::string::npos) << table;
}

TEST_F(Skipped, AgainAndAgainItEndsTheRunWithItsRepro) {
  const Fault fault{"nan", [](const torch::Tensor& loss, const torch::Tensor&) { return loss * kNaN; }};
  std::string text;
  for (int attempt = 0; attempt < 2; ++attempt) {
    // The second start continues and meets the same.
    Trainer trainer(config(20), folder_ / "run", faulty(fault, attempt == 0 ? 8 : 1, 100));
    text = error_text([&] { trainer.train(); });
    EXPECT_EQ(trainer.state().step, 7);
    EXPECT_EQ(trainer.state().optimizer_steps, 7);
    EXPECT_EQ(fs::read_symlink(folder_ / "run/checkpoints/last"), "step_00000007");
  }
  for (const std::string part : {"3 steps in a row", "from step 8 on", "seed 1", "frame_", " at ",
                                 "ld_train --config", "--out", "run/config.yaml"})
    EXPECT_NE(text.find(part), std::string::npos) << "no '" << part << "' in " << text;
  EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  // With the fault gone, the run is that of one which never met it.
  Trainer cured(config(20), folder_ / "run"), straight(config(20), folder_ / "straight");
  cured.train();
  straight.train();
  EXPECT_EQ(last_checkpoint(folder_ / "run"), last_checkpoint(folder_ / "straight"));
  EXPECT_EQ(read_file(folder_ / "run/metrics.csv"), read_file(folder_ / "straight/metrics.csv"));
}

INSTANTIATE_TEST_SUITE_P(
    Faults, Skipping,
    ::testing::Values(
        Fault{"nan_loss", [](const torch::Tensor& loss, const torch::Tensor&) { return loss * kNaN; }},
        Fault{"infinite_loss",
              [](const torch::Tensor& loss, const torch::Tensor&) { return loss * kInfinity; }},
        Fault{"nan_gradient",
              [](const torch::Tensor& loss, const torch::Tensor& d) { return loss + steep_zero(d, 0); }},
        Fault{"infinite_gradient",
              [](const torch::Tensor& loss, const torch::Tensor& d) { return loss + steep_zero(d, 1); }},
        Fault{"gradient_beyond_adams_squares",
              [](const torch::Tensor& loss, const torch::Tensor&) { return loss * 1e25; }}),
    [](const auto& fault) { return fault.param.name; });

TEST_F(Skipped, OneFaultyBatchOfAStepSkipsAllOfIt) {
  TrainConfig several = config(3);
  several.data.batch = 1;
  several.optimizer.accumulate = 3;
  const Fault fault{"nan", [](const torch::Tensor& loss, const torch::Tensor&) { return loss * kNaN; }};
  Trainer trainer(several, folder_ / "run", faulty(fault, 5, 5));
  trainer.train();
  EXPECT_EQ(trainer.state().optimizer_steps, 2);
  EXPECT_EQ(trainer.state().skipped, 1);
}

}  // namespace
}  // namespace ld
