// Each rank is a thread here, with a connection of its own; tests/apps/distributed_test.cpp has processes.
#include "training/distributed/process_group.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <limits>
#include <thread>

#include "dataset/training_set.h"
#include "losses/loss.h"
#include "models/initialise.h"
#include "tests/support/expect_error.h"
#include "tests/support/free_port.h"
#include "tests/support/ranks.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

torch::Tensor numbers_of(int rank, const std::vector<int64_t>& shape) {
  torch::Generator generator =
      torch::make_generator<torch::CPUGeneratorImpl>(static_cast<uint64_t>(rank) + 5);
  return torch::randn(shape, generator) * 100;
}

TEST(ProcessGroup, SumsHaveTheSameBitsOnEveryRankAndEveryTime) {
  for (const int size : {1, 2, 3, 5}) {
    std::vector<std::vector<torch::Tensor>> results(static_cast<size_t>(size));
    run_ranks(size, [&](std::unique_ptr<ProcessGroup> group) {
      std::vector<torch::Tensor>& mine = results[static_cast<size_t>(group->rank())];
      for (int repeat = 0; repeat < 2; ++repeat) {
        const torch::Tensor a = numbers_of(group->rank(), {3, 5, 7}), b = numbers_of(group->rank(), {}),
                            c = numbers_of(group->rank(), {1000, 2}).t();  // not contiguous
        group->sum({a, b, c}, "test");
        mine.insert(mine.end(), {a, b, c});
      }
      EXPECT_EQ(group->sum(1.5, "number"), 1.5 * size);
      EXPECT_TRUE(group->any(group->rank() == size - 1, "one"));
      EXPECT_FALSE(group->any(false, "none"));
      group->barrier("end");
    });
    torch::Tensor expected = torch::zeros({3, 5, 7}, torch::kFloat64);
    for (int rank = 0; rank < size; ++rank) expected += numbers_of(rank, {3, 5, 7}).to(torch::kFloat64);
    EXPECT_LT((results[0][0] - expected).abs().max().item<double>(), 1e-4);
    for (const std::vector<torch::Tensor>& of_rank : results)
      for (size_t i = 0; i < 6; ++i) EXPECT_TRUE(of_rank[i].equal(results[0][i % 3])) << size << " " << i;
  }
}

TEST(ProcessGroup, ANanOnOneRankIsANanOnAll) {
  run_ranks(3, [](std::unique_ptr<ProcessGroup> group) {
    const torch::Tensor values = torch::ones({4});
    if (group->rank() == 1) values[2] = std::numeric_limits<float>::quiet_NaN();
    if (group->rank() == 2) values[0] = std::numeric_limits<float>::infinity();
    if (group->rank() == 0) values[0] = -std::numeric_limits<float>::infinity();
    group->sum({values}, "gradients");
    EXPECT_TRUE(values.isfinite().equal(torch::tensor({false, true, false, true}))) << values;
    EXPECT_ERROR(group->sum({values, torch::ones({1}, torch::kFloat64)}, "two types"), "two types");
    group->barrier("end");
  });
}

TEST(ProcessGroup, BroadcastsTensorsOfAnyTypeAndText) {
  run_ranks(2, [](std::unique_ptr<ProcessGroup> group) {
    const bool root = group->is_root();
    const torch::Tensor floats = root ? torch::arange(6, torch::kFloat32).view({2, 3}) : torch::zeros({2, 3}),
                        integers = torch::full({1}, root ? int64_t{1} << 60 : 0, torch::kInt64),
                        halves = torch::full({3}, root ? 0.5 : 0.0, torch::kHalf);
    group->broadcast({floats, integers, halves}, "state");
    EXPECT_TRUE(floats.equal(torch::arange(6, torch::kFloat32).view({2, 3})));
    EXPECT_EQ(integers.item<int64_t>(), int64_t{1} << 60);
    EXPECT_TRUE(halves.equal(torch::full({3}, 0.5, torch::kHalf)));
    EXPECT_EQ(group->broadcast(root ? std::string("a\0b, long", 9) : "another", "text"),
              std::string("a\0b, long", 9));
    EXPECT_EQ(group->broadcast(std::string(), "empty"), "");
    EXPECT_ERROR(group->broadcast({torch::zeros({2, 3}).t()}, "columns"), "not contiguous");
    group->barrier("end");
  });
}

TEST(ProcessGroup, WhoHasAnotherConfigurationIsNamedOnEveryRank) {
  run_ranks(4, [](std::unique_ptr<ProcessGroup> group) {
    group->require_equal("same", "configuration");
    EXPECT_ERROR(group->require_equal(group->rank() % 2 == 0 ? "seed: 1" : "seed: 2", "configuration"),
                 "rank 1, 3: another configuration than rank 0 has");
    group->barrier("end");
  });
}

TEST(ProcessGroup, APeerThatLeavesEndsTheOthersAtOnce) {
  for (const int leaver : {0, 2}) {
    run_ranks(3, [&](std::unique_ptr<ProcessGroup> group) {
      group->barrier("start");
      if (group->rank() == leaver) return;
      const Clock::time_point start = Clock::now();
      EXPECT_ERROR(group->sum(1.0, "gradients of step 7"),
                   "rank " + std::to_string(group->rank()) + " of 3: lost a peer at 'gradients of step 7'");
      EXPECT_ERROR(group->barrier("again"), "lost a peer at 'again'");
      group.reset();
      EXPECT_LT(seconds_since(start), 10);
    });
  }
}

TEST(ProcessGroup, ABusyPeerIsWaitedForLongerThanTheTimeout) {
  run_ranks(
      2,
      [](std::unique_ptr<ProcessGroup> group) {
        if (group->is_root()) std::this_thread::sleep_for(milliseconds(1500));  // a long validation
        EXPECT_EQ(group->sum(1.0, "after the validation"), 2);
      },
      milliseconds(500));
}

TEST(ProcessGroup, WithoutItsPeersARankGivesUpAndSaysWhatToCheck) {
  ProcessGroupOptions options;
  options.size = 2;
  options.address = "127.0.0.1";
  options.port = free_port();
  options.start_timeout = milliseconds(1000);
  for (options.rank = 0; options.rank < 2; ++options.rank)
    EXPECT_ERROR(ProcessGroup{options}, "cannot meet the other processes at 127.0.0.1:");
  options.rank = 2;
  EXPECT_ERROR(ProcessGroup{options}, "expected a rank from 0 to 1");
}

TEST(ProcessGroup, TheEnvironmentIsPyTorchs) {
  const std::vector<const char*> names = {"WORLD_SIZE",
                                          "RANK",
                                          "MASTER_ADDR",
                                          "MASTER_PORT",
                                          "LD_PEER_TIMEOUT",
                                          "LD_START_TIMEOUT",
                                          "TORCHELASTIC_USE_AGENT_STORE"};
  const auto read = [&](const std::vector<const char*>& values) {
    for (size_t i = 0; i < names.size(); ++i) {
      unsetenv(names[i]);
      if (i < values.size() && values[i] != nullptr) setenv(names[i], values[i], 1);
    }
    return process_group_options_from_environment();
  };
  EXPECT_EQ(read({}).size, 1);
  EXPECT_EQ(read({"1", "0"}).size, 1);
  const ProcessGroupOptions options = read({"4", "3", "node0", "29500", "7.5", "60"});
  EXPECT_EQ(options.size, 4);
  EXPECT_EQ(options.rank, 3);
  EXPECT_EQ(options.address, "node0");
  EXPECT_EQ(options.port, 29500);
  EXPECT_EQ(options.peer_timeout, milliseconds(7500));
  EXPECT_EQ(options.start_timeout, milliseconds(60000));
  EXPECT_ERROR(read({"two"}), "WORLD_SIZE is 'two'; expected a number from 1");
  EXPECT_ERROR(read({"2"}), "RANK is not set, but WORLD_SIZE=2");
  EXPECT_ERROR(read({"2", "2"}), "RANK is '2'; expected a number from 0 to 1");
  EXPECT_ERROR(read({"2", "0"}), "MASTER_ADDR is not set");
  EXPECT_ERROR(read({"2", "0", "node0"}), "MASTER_PORT is not set");
  EXPECT_ERROR(read({"2", "0", "node0", "70000"}), "MASTER_PORT is '70000'");
  EXPECT_ERROR(read({"2", "0", "node0", "29500", "soon"}), "LD_PEER_TIMEOUT is 'soon'");
  EXPECT_ERROR(read({"2", "0", "node0", "29500", "30", "300", "True"}), "torchrun keeps MASTER_PORT=29500");
  EXPECT_EQ(read({"2", "0", "node0", "29500", "30", "300", "False"}).size, 2);
  read({});
  EXPECT_EQ(ProcessGroup::from_environment()->size(), 1);
}

/// Gradients of the mean loss over the batch of step 3, by so many processes.
std::vector<torch::Tensor> gradients(const std::filesystem::path& data, int processes) {
  const auto config =
      config_from_tree<NetworkConfig>(*parse_config(tiny_network_yaml(), "tiny").find("network"));
  std::vector<torch::Tensor> result;
  run_ranks(processes, [&](std::unique_ptr<ProcessGroup> group) {
    TrainingSetOptions options;
    options.augmentation.crop = 16;
    options.batch = 5;  // which 2 does not divide
    options.workers = 0;
    options.rank = group->rank();
    options.processes = group->size();
    std::vector<WeightedStore> sets;
    sets.push_back({std::make_unique<FrameStore>(data, "train", config.features, CacheOptions{}), 1});
    TrainingSet set(std::move(sets), config.features, options);
    const std::shared_ptr<Network> network = make_network(config);
    initialise(*network, 3);
    Batch batch = set.batch(3);
    (make_loss("smape")(network->forward(batch.input), batch.reference) * set.batch_share()).backward();
    std::vector<torch::Tensor> mine;
    for (const torch::Tensor& parameter : network->parameters()) mine.push_back(parameter.grad());
    group->sum(mine, "gradients");
    if (group->is_root()) result = mine;
  });
  return result;
}

TEST(ProcessGroup, ReducedGradientsAreThoseOfOneProcess) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 20);
  const std::vector<torch::Tensor> one = gradients(folder.path(), 1);
  ASSERT_GT(one.size(), 10u);
  for (const int processes : {2, 3}) {
    const std::vector<torch::Tensor> several = gradients(folder.path(), processes);
    ASSERT_EQ(several.size(), one.size());
    double square = 0, difference = 0;
    for (size_t i = 0; i < one.size(); ++i) {
      square += one[i].square().sum(torch::kFloat64).item<double>();
      difference += (one[i] - several[i]).square().sum(torch::kFloat64).item<double>();
    }
    EXPECT_GT(square, 0);
    EXPECT_LT(std::sqrt(difference / square), 2e-6) << processes << " processes";
  }
}

}  // namespace
}  // namespace ld
