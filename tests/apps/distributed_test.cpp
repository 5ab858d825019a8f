// Two processes of ld_train on this machine, found by the environment variables of PyTorch: killed, hung and
// asked to stop.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <thread>

#include "tests/support/free_port.h"
#include "tests/support/run_program.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

class TwoProcesses : public ::testing::Test {
 protected:
  void SetUp() override {
    write_tiny_dataset(folder_ / "data", 4);
    write_file_atomically(
        folder_ / "train.yaml",
        tiny_network_yaml() +
            "data:\n  crop: 16\n  batch: 4\noptimizer:\n  schedule: constant\nepochs: 1000000\n"
            "run:\n  log_every: 1\n  validate_every: 1000\n  checkpoint_every: 10\n  images: 0\n");
  }

  using Pair = std::vector<std::unique_ptr<RunningProgram>>;

  Pair start(const std::string& run, int steps, const std::string& peer_timeout = "30") {
    const std::string port = std::to_string(free_port());
    Pair pair;
    for (const char* rank : {"0", "1"})
      pair.push_back(std::make_unique<RunningProgram>(
          "ld_train",
          std::vector<std::string>{
              "--config", (folder_ / "train.yaml").string(), "--out", (folder_ / run).string(), "--threads",
              "1", "data.path=" + (folder_ / "data").string(), "run.max_steps=" + std::to_string(steps)},
          std::map<std::string, std::string>{{"RANK", rank},
                                             {"WORLD_SIZE", "2"},
                                             {"MASTER_ADDR", "127.0.0.1"},
                                             {"MASTER_PORT", port},
                                             {"LD_PEER_TIMEOUT", peer_timeout},
                                             {"OMP_WAIT_POLICY", "passive"}}));
    return pair;
  }

  void await_checkpoint(const std::string& run) {
    const auto deadline = Clock::now() + std::chrono::seconds(60);
    while (!fs::exists(folder_ / run / "checkpoints/last") && Clock::now() < deadline)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }

  void finish(const std::string& run, int steps) {
    for (const auto& process : start(run, steps)) {
      const int code = process->wait();
      EXPECT_EQ(code, 0) << process->output();
    }
  }

  int steps(const std::string& run) {
    return std::stoi(fs::read_symlink(folder_ / run / "checkpoints/last").string().substr(5));
  }

  /// What a run may not lose: weights, moments and log rows.
  std::string remains(const std::string& run) {
    std::string bytes = read_file(folder_ / run / "metrics.csv");
    for (const char* name : {"weights.safetensors", "optimizer.safetensors", "state.json"})
      bytes += read_file(folder_ / run / "checkpoints/last" / name);
    return bytes;
  }

  TemporaryFolder folder_;
};

TEST_F(TwoProcesses, KilledTogetherTheyGoOnBitForBit) {
  const Pair pair = start("killed", 1000000);
  await_checkpoint("killed");
  for (const auto& process : pair) process->signal(SIGKILL);
  for (const auto& process : pair) EXPECT_EQ(process->wait(), -SIGKILL) << process->output();
  const int more = steps("killed") + 15;
  finish("killed", more);
  finish("straight", more);
  EXPECT_EQ(remains("killed"), remains("straight"));
}

/// One process is lost in some way, the other must end soon with exit code 1, say why, and leave a checkpoint
/// to continue from.
class LostPeerTest : public TwoProcesses, public ::testing::WithParamInterface<std::pair<int, int>> {};

TEST_P(LostPeerTest, EndsTheOtherWithAUsableCheckpoint) {
  const auto [lost, signal] = GetParam();
  const Pair pair = start("run", 1000000, "2");
  await_checkpoint("run");
  RunningProgram &gone = *pair[static_cast<size_t>(lost)], &other = *pair[static_cast<size_t>(1 - lost)];
  gone.signal(signal);
  const Clock::time_point since = Clock::now();
  const int code = other.wait();
  EXPECT_LT(std::chrono::duration<double>(Clock::now() - since).count(), 30);
  const std::string rank = std::to_string(1 - lost);
  expect_failure({code, other.output()}, 1,
                 {"rank " + rank + " of 2: lost a peer", "start all of them again"});
  gone.signal(SIGKILL);
  gone.wait();
  const int done = steps("run");
  EXPECT_GE(done, 10);
  finish("run", done + 3);
  EXPECT_EQ(steps("run"), done + 3);
}

INSTANTIATE_TEST_SUITE_P(Ways, LostPeerTest,
                         ::testing::Values(std::pair<int, int>{1, SIGKILL}, std::pair<int, int>{0, SIGKILL},
                                           std::pair<int, int>{1, SIGSTOP}),
                         [](const auto& test) {
                           return std::string(test.param.second == SIGKILL ? "killed" : "hung") + "_rank_" +
                                  std::to_string(test.param.first);
                         });

TEST_F(TwoProcesses, ASignalToOneStopsBothAfterTheSameStep) {
  const Pair pair = start("run", 1000000);
  await_checkpoint("run");
  pair[1]->signal(SIGTERM);
  EXPECT_EQ(pair[1]->wait(), 143) << pair[1]->output();
  EXPECT_EQ(pair[0]->wait(), 0) << pair[0]->output();
  const int more = steps("run") + 5;
  finish("run", more);
  EXPECT_EQ(steps("run"), more);
}

}  // namespace
}  // namespace ld
