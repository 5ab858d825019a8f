// Networks that remember, in the runtime, against LibTorch over sequences.
#include <gtest/gtest.h>

#include <optional>

#include "dataset/input_tensors.h"
#include "tests/models/small_network.h"
#include "tests/runtime/run_graph.h"
#include "tests/support/expect_error.h"
#include "tests/support/moving_frame.h"

namespace ld {
namespace {

constexpr uint32_t kFrames = 5;

/// Of every network that keeps a state.
std::vector<NetworkConfig> remembering_configs() {
  std::vector<NetworkConfig> configs;
  for (NetworkConfig config : every_config()) {
    if (!network_traits(config.name).remembers) continue;
    for (const char* name : {"normal", "flow"})
      if (first_channel(config.features, name) < 0) config.features.emplace_back(name);
    configs.push_back(config);
    config.exposure_normalisation = true;
    configs.push_back(config);
  }
  return configs;
}

/// The pictures of frames [first, last); `state` as in Execution.
std::vector<Image> in_runtime(Execution& execution, int width, int height, int spp, uint32_t first,
                              uint32_t last, FrameState& state) {
  std::vector<Image> pictures;
  for (uint32_t f = first; f < last; ++f) {
    std::vector<Image> made = execution.run(moving_frame(width, height, spp, f), {}, state);
    pictures.push_back(made[0]);
    state.assign(made.begin() + 1, made.end());
  }
  return pictures;
}

float largest_of(const Image& image) {
  return *std::max_element(image.pixels.begin(), image.pixels.end());
}

float difference_of(const Image& a, const Image& b) {
  float most = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) most = std::max(most, std::fabs(a.pixels[i] - b.pixels[i]));
  return most;
}

TEST(HistoryParity, TheGraphGivesThePicturesAndTheStateOfTheNetwork) {
  const torch::NoGradGuard no_graph;
  ASSERT_FALSE(remembering_configs().empty());
  for (const NetworkConfig& config : remembering_configs())
    for (const auto& [width, height, spp] :
         {std::tuple(1, 1, 1), std::tuple(7, 5, 3), std::tuple(33, 70, 2)}) {
      const auto network = small_network(config, torch::kFloat32);
      const graph::Graph graph = network_graph(config);
      const NamedWeights weights = weights_of(*network);
      Execution execution(graph, weights, {spp, height, width}, {2});
      NetworkState expected_state;
      FrameState state;
      for (uint32_t f = 0; f < kFrames; ++f) {
        SCOPED_TRACE(title(config) + " frame " + std::to_string(f) + " " + std::to_string(width));
        const Image expected =
            to_image(network
                         ->forward(make_network_input({moving_frame(width, height, spp, f)}, config.features),
                                   expected_state)
                         .squeeze(0));
        const Image found = in_runtime(execution, width, height, spp, f, f + 1, state)[0];
        EXPECT_LE(difference_of(found, expected), 1e-5F * largest_of(expected));
        ASSERT_EQ(state.size(), 3U);
        size_t part = 0;
        for (const char* name : {"light", "frames", "surface"}) {
          const Image left = to_image(expected_state.at(name).squeeze(0));
          EXPECT_LE(difference_of(state[part++], left), 1e-5F * std::max(largest_of(left), 1.0F)) << name;
        }
      }
      if (width > 1) {
        EXPECT_GT(largest_of(state[1]), 1.5F) << "no pixel has a history";
      }
    }
}

TEST(HistoryParity, HalvesWithTheStatePassedOnAreTheWholeAndRowsAndThreadsChangeNoBit) {
  const NetworkConfig config = remembering_configs().back();
  const graph::Graph graph = network_graph(config);
  const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
  const auto run = [&](const std::vector<std::pair<uint32_t, uint32_t>>& pieces,
                       const ExecutionOptions& options) {
    std::vector<Image> pictures;
    FrameState state;
    for (const auto& [first, last] : pieces) {
      Execution execution(graph, weights, {2, 40, 33}, options);
      for (Image& picture : in_runtime(execution, 33, 40, 2, first, last, state))
        pictures.push_back(std::move(picture));
    }
    return pictures;
  };
  const std::vector<Image> whole = run({{0, kFrames}}, {1});
  for (const int64_t block : {0, 1, 16})
    for (const int threads : {1, 2}) {
      const std::vector<Image> halves = run({{0, 2}, {2, kFrames}}, {threads, block});
      for (uint32_t f = 0; f < kFrames; ++f)
        EXPECT_EQ(halves[f].pixels, whole[f].pixels) << f << " " << block;
    }
}

TEST(HistoryParity, AStateThatDoesNotFitIsAnError) {
  const NetworkConfig config = remembering_configs()[0];
  const graph::Graph graph = network_graph(config);
  const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
  Execution execution(graph, weights, {1, 6, 8});
  FrameState state;
  in_runtime(execution, 8, 6, 1, 0, 1, state);
  FrameState turned = state;
  turned[2] = Image(6, 8, 4);
  EXPECT_ERROR(execution.run(moving_frame(8, 6, 1, 1), {}, turned), "state of a frame before");
  state.pop_back();
  EXPECT_ERROR(execution.run(moving_frame(8, 6, 1, 1), {}, state), "state of a frame before");
}

}  // namespace
}  // namespace ld
