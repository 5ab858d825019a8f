// Validation walks sequences in order, and what a network sees of each frame does not depend on that.
#include "training/validation.h"

#include <gtest/gtest.h>

#include <mutex>

#include "core/process/process_memory.h"
#include "metrics/metric.h"
#include "models/initialise.h"
#include "ops/memory_pool.h"
#include "tests/support/ranks.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"
#include "tests/support/tiny_sequences.h"
#include "tests/training/tiny_training.h"
#include "training/estimate.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kSeen = {"radiance", "normal"};

Validation validation_of(const std::vector<fs::path>& folders, int64_t pictures = 2,
                         const std::vector<std::string>& features = kSeen) {
  std::vector<std::unique_ptr<FrameStore>> stores;
  for (const fs::path& folder : folders)
    stores.push_back(std::make_unique<FrameStore>(folder, "validation", features, CacheOptions{"none", 0}));
  return Validation(std::move(stores), pictures);
}

/// Frames as "number:history"; each is denoised to its mean plus what is remembered of the one before.
Validation::Denoise recorder(std::vector<std::string>& seen) {
  return
      [&seen](const NetworkInput& input, const torch::Tensor& reference, SequenceState& state) -> Compared {
        const auto number = static_cast<int>(input.radiance[0][0][1].min().item<float>());
        seen.push_back(fmt::format("{}:{}", number, state.history()));
        EXPECT_EQ(state.memory.has_value(), state.history() > 0);
        if (state.memory.has_value()) {
          EXPECT_EQ(std::any_cast<int>(state.memory), number - 1);
        }
        state.memory = number;
        const torch::Tensor mean = input.radiance.mean(1);
        return {mean, mean, reference};
      };
}

std::function<bool()> never() {
  return [] { return false; };
}

TEST(Validation, WalksSequencesInOrderAndRestartsAtHoles) {
  const TemporaryFolder folder;
  write_tiny_sequences(folder / "a", {4, 2}, "validation");
  write_tiny_sequences(folder / "b", {2}, "validation");
  // The frames of the first sequence lie in the wrong order on the disk, and one of them is missing.
  Manifest manifest = read_manifest(folder / "a");
  std::swap(manifest.frames[0].position, manifest.frames[1].position);
  for (int i = 0; i < 2; ++i)
    write_numbered_frame(folder / "a", manifest.frames[size_t(i)].name, 1 - i, 16, 2);
  manifest.frames[2].split = "test";
  add_to_manifest(folder / "a", manifest);

  std::vector<std::string> seen;
  ProcessGroup alone{ProcessGroupOptions{}};
  const Validation validation = validation_of({folder / "a", folder / "b"});
  EXPECT_EQ(validation.frames(), 7u);
  const auto result = validation.run(recorder(seen), kSeen, make_loss("l1"), alone, never());
  EXPECT_EQ(seen, (std::vector<std::string>{"0:0", "1:1", "3:0", "100:0", "101:1", "0:0", "1:1"}));
  ASSERT_EQ(result->pictures.size(), 2u);
  EXPECT_EQ(result->pictures[0].name, "validation_0_01") << "position 0 of the first sequence";
  EXPECT_EQ(result->pictures[1].name, "validation_1_00");
}

TEST(Validation, AProcessWalksWholeSequencesAndTheScoresStay) {
  const TemporaryFolder folder;
  write_tiny_sequences(folder.path(), {3, 1, 2}, "validation");
  const Validation validation = validation_of({folder.path()});
  std::vector<std::string> alone_seen;
  ProcessGroup alone{ProcessGroupOptions{}};
  const auto expected = validation.run(recorder(alone_seen), kSeen, make_loss("l1"), alone, never());
  std::mutex mutex;
  run_ranks(2, [&](std::unique_ptr<ProcessGroup> group) {
    std::vector<std::string> seen;
    const auto result = validation.run(recorder(seen), kSeen, make_loss("l1"), *group, never());
    const std::lock_guard<std::mutex> lock(mutex);
    EXPECT_EQ(seen, group->is_root() ? (std::vector<std::string>{"0:0", "1:1", "2:2", "200:0", "201:1"})
                                     : (std::vector<std::string>{"100:0"}));
    EXPECT_EQ(result->scores, expected->scores);
    EXPECT_EQ(result->pictures.size(), group->is_root() ? 2u : 0u);
  });
}

// Of a network of single frames: in a sequence, and as stills, frames give the picture that they give alone.
TEST(Validation, PicturesOfNetworksDoNotKnowOfSequences) {
  const TemporaryFolder folder;
  const TrainConfig config = tiny_config(folder.path(), 1);
  write_tiny_dataset(folder / "stills", 0);
  write_tiny_dataset(folder / "sequence", 1);
  Manifest manifest = read_manifest(folder / "sequence");
  for (size_t i = 0; i < manifest.frames.size(); ++i) {
    manifest.frames[i].split = "validation";
    manifest.frames[i].sequence = 0;
    manifest.frames[i].position = static_cast<int64_t>(i);
  }
  add_to_manifest(folder / "sequence", manifest);

  const std::shared_ptr<Network> network = make_network(config.network);
  initialise(*network, 1);
  ProcessGroup alone{ProcessGroupOptions{}};
  const std::vector<std::string>& features = config.network.features;
  const Validation validation = validation_of({folder / "stills", folder / "sequence"}, 4, features);
  const auto result = validation.run(*network, make_loss("smape"), alone, never());
  ASSERT_EQ(result->pictures.size(), 4u);
  std::vector<double> sums(metrics().size());
  for (size_t i = 0; i < 4; ++i) {
    FrameStore store(i == 0 ? folder / "stills" : folder / "sequence", "validation", features, {"none", 0});
    Augmentation whole;
    whole.width = whole.height = 16;
    Batch batch = make_batch({{store.get(i == 0 ? 0 : i - 1), whole}}, features);
    const torch::NoGradGuard no_graph;
    const Image denoised = to_image(network->forward(std::move(batch.input)).squeeze(0));
    EXPECT_EQ(result->pictures[i].denoised.pixels, denoised.pixels) << i;
    for (size_t m = 0; m < metrics().size(); ++m)
      sums[m] += metrics()[m].compute(denoised, to_image(batch.reference.squeeze(0)));
  }
  for (size_t m = 0; m < metrics().size(); ++m)
    EXPECT_NEAR(result->scores.at(metrics()[m].name), sums[m] / 4, 1e-12);
}

// A network that remembers has its state along each sequence, and none at its start.
TEST(Validation, NetworksThatRememberHaveTheirState) {
  const TemporaryFolder folder;
  write_tiny_sequences(folder.path(), {3, 2}, "validation");
  TrainConfig config = tiny_config(folder.path(), 1);
  config.network.name = "layer_history";
  config.network.features = kSeen;  // nothing moves
  const std::shared_ptr<Network> network = make_network(config.network);
  initialise(*network, 1);
  ProcessGroup alone{ProcessGroupOptions{}};
  const Validation validation = validation_of({folder.path()}, 5, config.network.features);
  const auto result = validation.run(*network, make_loss("smape"), alone, never());
  ASSERT_EQ(result->pictures.size(), 5u);
  FrameStore store(folder.path(), "validation", config.network.features, {"none", 0});
  const torch::NoGradGuard no_graph;
  NetworkState state;
  for (size_t i = 0; i < 5; ++i) {
    if (i == 3) state.clear();
    Augmentation whole;
    whole.width = whole.height = 16;
    const Batch batch = make_batch({{store.get(i), whole}}, config.network.features);
    const Image expected = to_image(network->forward(batch.input, state).squeeze(0));
    EXPECT_EQ(result->pictures[i].denoised.pixels, expected.pixels) << i;
  }
}

// The frame is larger than the piece of it that is measured.
TEST(Validation, TheEstimateCountsWholeFrames) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 0, 640);
  const TrainConfig config = tiny_config(folder.path(), 1);
  const std::shared_ptr<Network> network = make_network(config.network);
  initialise(*network, 1);
  const Validation validation = validation_of({folder.path()}, 1, config.network.features);
  EXPECT_EQ(validation.pixels_of_largest(), 640 * 640);
  use_memory_pool();
  const ValidationCost cost = measure_validation(*network, validation, never());
  const double beside = static_cast<double>(resident_bytes() + validation.picture_bytes()) / 1e6;
  const int64_t before = memory_pool_state().live;
  ProcessGroup alone{ProcessGroupOptions{}};
  validation.run(*network, make_loss("smape"), alone, never());
  const double needed = static_cast<double>(memory_pool_state().peak_live - before) / 1e6;
  EXPECT_GT(needed, 100);
  EXPECT_NEAR(cost.megabytes - beside, needed, 0.1 * needed);
  EXPECT_GT(cost.seconds_per_pixel, 0);
}

}  // namespace
}  // namespace ld
