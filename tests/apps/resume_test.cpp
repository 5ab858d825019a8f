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
    return {"--config",
            (folder_ / "train.yaml").string(),
            "--out",
            (folder_ / run).string(),
            "data.path=" + (folder_ / "data").string(),
            "run.max_steps=" + std::to_string(steps)};
  }
  std::string weights(const std::string& run) {
    return read_file(folder_ / run / "checkpoints/last/weights.safetensors");
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
};

TEST_F(Resume, ATrainingThatWasKilledEndsWithTheSameWeights) {
  EXPECT_EQ(interrupt("killed", SIGKILL), -SIGKILL);
  const int more = steps("killed") + 20;
  EXPECT_EQ(run_program("ld_train", arguments("killed", more)).exit_code, 0);
  EXPECT_EQ(run_program("ld_train", arguments("straight", more)).exit_code, 0);
  EXPECT_EQ(weights("killed"), weights("straight"));
}

TEST_F(Resume, SigtermAndSigintSaveAndSaySo) {
  EXPECT_EQ(interrupt("terminated", SIGTERM), 143);
  EXPECT_EQ(interrupt("interrupted", SIGINT), 130);
  const int more = steps("terminated") + 7;
  EXPECT_EQ(run_program("ld_train", arguments("terminated", more)).exit_code, 0);
  EXPECT_EQ(run_program("ld_train", arguments("straight", more)).exit_code, 0);
  EXPECT_EQ(weights("terminated"), weights("straight"));
}

}  // namespace
}  // namespace ld
