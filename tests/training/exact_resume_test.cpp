// Stopping and continuing changes no bit, in every mode; nor does a kill at any moment.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <thread>

#include "core/random.h"
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

class ExactResume : public ::testing::TestWithParam<Mode> {
 protected:
  void SetUp() override { write_tiny_dataset(folder_ / "data", 4); }
  void train(const std::string& run, int64_t steps) {
    TrainConfig config = tiny_config(folder_ / "data", steps);
    config.epochs = 15;  // so that 30 steps see the whole schedule
    GetParam().set(config);
    Trainer trainer(config, folder_ / run);
    trainer.train();
    EXPECT_EQ(trainer.state().step, std::min(steps, trainer.total_steps()));
  }
  TemporaryFolder folder_;
};

TEST_P(ExactResume, TwoHalvesAreTheWhole) {
  train("straight", 20);
  train("halves", 10);
  train("halves", 20);
  EXPECT_EQ(last_checkpoint(folder_ / "straight"), last_checkpoint(folder_ / "halves"));
  EXPECT_EQ(read_file(folder_ / "straight/metrics.csv"), read_file(folder_ / "halves/metrics.csv"));
}

INSTANTIATE_TEST_SUITE_P(
    Modes, ExactResume,
    ::testing::Values(Mode{"constant", [](TrainConfig& c) { c.optimizer.schedule = "constant"; }},
                      Mode{"step_accumulate",
                           [](TrainConfig& c) {
                             c.optimizer.schedule = "step";
                             c.optimizer.step_epochs = 3;
                             c.data.batch = 1;
                             c.optimizer.accumulate = 3;
                             c.epochs = 30;
                           }},
                      Mode{"cosine_ema", [](TrainConfig& c) { c.optimizer.ema = 0.95; }},
                      Mode{"one_cycle_accumulate_ema",
                           [](TrainConfig& c) {
                             c.optimizer.schedule = "one_cycle";
                             c.optimizer.accumulate = 2;
                             c.optimizer.ema = 0.9;
                             c.epochs = 30;
                           }},
                      Mode{"warmup_clip_ema",
                           [](TrainConfig& c) {
                             c.optimizer.schedule = "constant";
                             c.optimizer.warmup_steps = 14;
                             c.optimizer.clip_norm = 0.1;
                             c.optimizer.clip_value = 0.05;
                             c.optimizer.ema = 0.99;
                           }},
                      Mode{"adamw_ema",
                           [](TrainConfig& c) {
                             c.optimizer.name = "adamw";
                             c.optimizer.weight_decay = 0.1;
                             c.optimizer.ema = 0.9;
                           }},
                      Mode{"drawn_samples_accumulate",
                           [](TrainConfig& c) {
                             c.data.samples = {1, 2};
                             c.optimizer.accumulate = 2;
                             c.epochs = 30;
                           }},
                      Mode{"no_rows_at_the_cut", [](TrainConfig& c) { c.run.log_every = 7; }}),
    [](const auto& mode) { return mode.param.name; });

/// What the process that saves tells the one that kills it.
struct Shared {
  std::atomic<bool> running{false};
  std::atomic<int64_t> written{0};  // newest checkpoint that was reported as saved
};

/// Memory that two processes share.
class SharedMemory {
 public:
  SharedMemory()
      : memory_(mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)),
        shared_(memory_ == MAP_FAILED ? nullptr : new (memory_) Shared) {}
  ~SharedMemory() { munmap(memory_, sizeof(Shared)); }
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  Shared* operator->() const { return shared_; }

 private:
  void* memory_;
  Shared* shared_;
};

class Kill : public ::testing::Test {
 protected:
  Kill()
      : network_(
            make_network(config_from_tree<TrainConfig>(parse_config(tiny_network_yaml(), "tiny")).network)),
        optimizer_(network_, with_average()) {}
  static OptimizerConfig with_average() {
    OptimizerConfig config;
    config.ema = 0.9;
    return config;
  }
  /// All weights are the number of the step.
  void save(int64_t step) {
    const torch::NoGradGuard no_graph;
    for (torch::Tensor& parameter : network_->parameters()) parameter.fill_(static_cast<double>(step));
    TrainingState state;
    state.step = step;
    CheckpointFolder(folder_.path(), 2)
        .write(
            step,
            [&](const fs::path& path) { write_checkpoint_files(path, state, *network_, optimizer_, ""); },
            step % 3 == 0);
  }
  [[noreturn]] void save_for_ever(int64_t step) {
    shared_->running = true;
    for (;; ++step) {
      save(step);
      shared_->written = step;
    }
  }
  bool holds_file(const std::string& start) const {
    for (const auto& entry : fs::directory_iterator(folder_ / "checkpoints"))
      if (entry.path().filename().string().rfind(start, 0) == 0) return true;
    return false;
  }

  TemporaryFolder folder_;
  std::shared_ptr<Network> network_;
  Optimizer optimizer_;
  SharedMemory shared_;
};

TEST_F(Kill, TheNewestWholeCheckpointAlwaysLoads) {
  constexpr int kKills = 100;
  const auto start = std::chrono::steady_clock::now();
  for (int64_t step = 1; step <= 4; ++step) save(step);
  const std::chrono::duration<double> save_time = (std::chrono::steady_clock::now() - start) / 4;
  shared_->written = 4;

  RandomStream stream(1, RandomPurpose::test);
  int during_a_save = 0;
  for (int number = 0; number < kKills; ++number) {
    shared_->running = false;
    const pid_t child = fork();
    if (child == 0) save_for_ever(shared_->written + 1);
    while (!shared_->running) std::this_thread::sleep_for(std::chrono::microseconds(100));
    std::this_thread::sleep_for(save_time * 3 * stream.uniform());
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    if (holds_file(".step_")) ++during_a_save;

    const auto newest = CheckpointFolder(folder_.path(), 2).newest_whole();
    ASSERT_TRUE(newest);
    const TrainingState state = read_checkpoint(*newest, *network_, optimizer_);
    // What was reported as saved is never lost; the one after it may just have come to be there.
    EXPECT_GE(state.step, shared_->written.load());
    EXPECT_LE(state.step, shared_->written + 1);
    EXPECT_TRUE(all_parameters(*network_).eq(static_cast<double>(state.step)).all().item<bool>());
    EXPECT_FALSE(holds_file("damaged"));
    shared_->written = state.step;
  }
  // How many depends on the machine's mood; some of each must have been.
  EXPECT_GT(shared_->written, 4 + kKills / 10);
  EXPECT_GT(during_a_save, kKills / 10) << "the others were killed between two saves";
}

}  // namespace
}  // namespace ld
