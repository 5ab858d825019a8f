// Programs that are stopped or killed go on where they were, bit for bit.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/support/run_program.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

class Resume : public ::testing::Test {
 protected:
  void SetUp() override {
    write_tiny_dataset(folder_ / "data", 4);
    write_file_atomically(folder_ / "train.yaml", tiny_network_yaml() +
                                                      "data:\n  crop: 16\n  batch: 4\n"
                                                      "run:\n  validate_every: 10\n  checkpoint_every: 10\n");
  }
  std::vector<std::string> arguments(const std::string& run, int steps) {
    std::vector<std::string> words = {"--config",
                                      (folder_ / "train.yaml").string(),
                                      "--out",
                                      (folder_ / run).string(),
                                      "data.path=" + (folder_ / "data").string(),
                                      "run.max_steps=" + std::to_string(steps)};
    words.insert(words.end(), settings_.begin(), settings_.end());
    return words;
  }
  /// Weights, moments, state and the rows of the log.
  std::string result(const std::string& run) {
    std::string bytes = read_file(folder_ / run / "metrics.csv");
    for (const char* name : {"weights.safetensors", "optimizer.safetensors", "state.json"})
      bytes += read_file(folder_ / run / "checkpoints/last" / name);
    return bytes;
  }

  /// Waits until the run has a checkpoint, then sends the signal; the program must still have had work to do.
  int interrupt(const std::string& run, int number) {
    RunningProgram program("ld_train", arguments(run, 1000000));
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!fs::exists(folder_ / run / "checkpoints/last") && std::chrono::steady_clock::now() < deadline)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    program.signal(number);
    return program.wait();
  }
  /// Steps of the last checkpoint, from the name that its link points to.
  int steps(const std::string& run) {
    return std::stoi(fs::read_symlink(folder_ / run / "checkpoints/last").string().substr(5));
  }

  TemporaryFolder folder_;
  std::vector<std::string> settings_;
};

TEST_F(Resume, ATrainingThatWasKilledEndsWithTheSameBytes) {
  settings_ = {"data.batch=2", "optimizer.accumulate=2", "optimizer.schedule=one_cycle", "optimizer.ema=0.99",
               "run.log_every=7"};
  EXPECT_EQ(interrupt("killed", SIGKILL), -SIGKILL);
  const int more = steps("killed") + 20;
  EXPECT_EQ(run_program("ld_train", arguments("killed", more)).exit_code, 0);
  EXPECT_EQ(run_program("ld_train", arguments("straight", more)).exit_code, 0);
  EXPECT_EQ(result("killed"), result("straight"));
}

TEST_F(Resume, SigtermAndSigintSaveAndSaySo) {
  EXPECT_EQ(interrupt("terminated", SIGTERM), 143);
  EXPECT_EQ(interrupt("interrupted", SIGINT), 130);
  const int more = steps("terminated") + 7;
  EXPECT_EQ(run_program("ld_train", arguments("terminated", more)).exit_code, 0);
  EXPECT_EQ(run_program("ld_train", arguments("straight", more)).exit_code, 0);
  EXPECT_EQ(result("terminated"), result("straight"));
}

}  // namespace
}  // namespace ld
