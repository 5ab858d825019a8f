// Trainings on another device than the CPU: a fake one everywhere, CUDA where there is some.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/support/expect_error.h"
#include "tests/support/fake_device.h"
#include "tests/support/ranks.h"
#include "tests/support/tensors.h"
#include "tests/training/tiny_training.h"
#include "training/device.h"

namespace ld {
namespace {

namespace fs = std::filesystem;
using torch::Tensor;

TEST(TrainingDevice, CudaThatIsNotThereIsOneError) {
  EXPECT_TRUE(device_named("cpu").is_cpu());
  if (torch::cuda::is_available()) GTEST_SKIP() << "there is a GPU here";
  EXPECT_ERROR(
      device_named("cuda", "train.yaml:7"),
      "train.yaml:7: run.device: expected cpu, or cuda with a GPU that LibTorch can use, found cuda");
  const TemporaryFolder folder;
  TrainConfig config = tiny_config(folder / "data", 1);  // which is not there, either
  config.run.device = "cuda";
  EXPECT_ERROR(Trainer(config, folder / "run"), "run.device=cpu");
  EXPECT_FALSE(fs::exists(folder / "run"));
}

TEST(TrainingDevice, ProcessesSendWhatIsOnAnother) {
  run_ranks(2, [](std::unique_ptr<ProcessGroup> group) {
    const auto own = static_cast<float>(group->rank() + 1);
    const Tensor one = torch::full({2, 3}, own, fake_device()),
                 two = torch::full({4}, 2 * own, fake_device());
    group->sum({one, two}, "adding");
    EXPECT_TRUE(one.cpu().eq(3).all().item<bool>());
    EXPECT_TRUE(two.cpu().eq(6).all().item<bool>());
    const Tensor sent = torch::full({5}, own, fake_device()), number = torch::full({1}, own, torch::kFloat64);
    group->broadcast({sent, number}, "sending");
    EXPECT_TRUE(sent.cpu().eq(1).all().item<bool>());
    EXPECT_EQ(number.item<double>(), 1);
  });
}

/// Trainings on a device against those of the CPU.
class DeviceTraining : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == "cuda" && !torch::cuda::is_available()) GTEST_SKIP() << "no GPU that LibTorch can use";
    if (const std::string why = no_fake_gradients(); GetParam() != "cuda" && !why.empty())
      GTEST_SKIP() << why;
    write_tiny_dataset(folder_ / "data", 4);
  }
  /// All that an optimizer can do.
  TrainConfig config(int64_t steps, const std::string& device) const {
    TrainConfig config = tiny_config(folder_ / "data", steps);
    config.optimizer.name = "adamw";
    config.optimizer.weight_decay = 0.01;
    config.optimizer.clip_norm = 0.5;
    config.optimizer.clip_value = 0.2;
    config.optimizer.accumulate = 2;
    config.optimizer.ema = 0.9;
    config.run.log_every = 1;
    config.run.device = device;
    return config;
  }
  void train(const std::string& run, int64_t steps, const std::string& device,
             const TrainerOptions& options = {}) const {
    Trainer trainer(config(steps, device), folder_ / run, options);
    trainer.train();
    EXPECT_EQ(trainer.state().step, steps);
    EXPECT_EQ(trainer.state().skipped, 0);
    EXPECT_EQ(trainer.network().device().type(), torch::Device(device).type());
    EXPECT_EQ(trainer.averaged_network().device().type(), torch::Device(device).type());
  }
  /// metrics.csv of two runs, to rounding. Where a run paused it has validated, and the other may have not.
  void expect_equal_tables(const std::string& run, const std::string& other) const {
    std::istringstream table(read_file(folder_ / run / "metrics.csv")),
        other_table(read_file(folder_ / other / "metrics.csv"));
    std::string row, other_row;
    while (std::getline(table, row) && std::getline(other_table, other_row)) {
      std::istringstream cells(row), other_cells(other_row);
      for (std::string a, b; std::getline(cells, a, ',') && std::getline(other_cells, b, ',');)
        if (a != b && !a.empty() && !b.empty()) {
          EXPECT_NEAR(std::stod(a), std::stod(b), 2e-3 * (0.01 + std::abs(std::stod(b)))) << row << "\n"
                                                                                          << other_row;
        }
    }
    EXPECT_TRUE(table.eof() && !std::getline(other_table, other_row)) << "one has more rows";
  }
  /// As if the run had been on that device: its name is one that no configuration of a user may have.
  void stored_as_of_the_cpu(const std::string& run) const {
    const fs::path path = folder_ / run / "config.yaml";
    std::string text = read_file(path);
    const std::string device = "device: " + GetParam();
    const size_t at = text.find(device);
    ASSERT_NE(at, std::string::npos);
    write_file_atomically(path, text.replace(at, device.size(), "device: cpu"));
  }
  TemporaryFolder folder_;
};

TEST_P(DeviceTraining, TenStepsAreThoseOfTheCpu) {
  train("cpu", 10, "cpu");
  train("device", 10, GetParam());
  expect_equal_tables("device", "cpu");
}

TEST_P(DeviceTraining, ARunGoesOnOnAnother) {
  train("cpu", 10, "cpu");
  train("both", 4, "cpu");
  train("both", 7, GetParam());
  stored_as_of_the_cpu("both");
  train("both", 10, "cpu");
  expect_equal_tables("both", "cpu");
  Trainer from(config(10, "cpu"), folder_ / "both"), straight(config(10, "cpu"), folder_ / "cpu");
  expect_near(all_parameters(from.network()), all_parameters(straight.network()), 2e-3);
}

TEST_P(DeviceTraining, ACollapseIsUndone) {
  int looked = 0;
  TrainerOptions options;
  options.loss = [&looked, smape = make_loss("smape")](const Tensor& denoised, const Tensor& reference) {
    const bool worse = looked == 1 && !torch::GradMode::is_enabled();  // than the best: in the 2nd validation
    return smape(denoised, reference) * (worse ? 1e6 : 1);
  };
  options.kernel_probe = [&](Network& network, const NetworkInput& input) {
    KernelStatistics statistics = kernel_statistics(network, input);
    if (++looked == 2) statistics.entropy = 0;
    return statistics;
  };
  TrainConfig collapsing = config(40, GetParam());
  collapsing.watch.entropy = 1e-6;
  collapsing.watch.patience = 1;
  Trainer trainer(collapsing, folder_ / "run", options);
  trainer.train();
  EXPECT_EQ(trainer.state().step, 40);
  EXPECT_EQ(trainer.state().rollbacks, 1);
}

TEST_P(DeviceTraining, AScheduleByTimeIsMeasuredThere) {
  TrainConfig timed = config(6, GetParam());
  timed.run.minutes = 0.05;
  Trainer trainer(timed, folder_ / "run");
  trainer.train();
  EXPECT_EQ(trainer.state().step, 6);
  EXPECT_GT(trainer.total_steps(), 6);
}

TEST_P(DeviceTraining, ProcessesShareOneRun) {
  train("one", 6, GetParam());
  run_ranks(2, [&](std::unique_ptr<ProcessGroup> group) {
    TrainerOptions options;
    options.group = group.get();
    train(group->is_root() ? "two" : "elsewhere", 6, GetParam(), options);
  });
  expect_equal_tables("two", "one");
  run_ranks(2, [&](std::unique_ptr<ProcessGroup> group) {
    TrainerOptions options;
    options.group = group.get();
    EXPECT_ERROR(Trainer(config(6, group->is_root() ? "cpu" : GetParam()), folder_ / "mixed", options),
                 "rank 1: another run.device");
  });
}

INSTANTIATE_TEST_SUITE_P(Devices, DeviceTraining, ::testing::Values("xpu", "cuda"),
                         [](const auto& device) { return device.param == "cuda" ? "Cuda" : "Fake"; });

}  // namespace
}  // namespace ld
