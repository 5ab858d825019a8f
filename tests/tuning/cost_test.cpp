#include "tuning/cost.h"

#include <gtest/gtest.h>

#include "tests/tuning/fake_search.h"

namespace ld {
namespace {

TEST(TuningCost, EveryCandidateRunsAndHasAPrediction) {
  const std::vector<Candidate> space = candidate_space({}, fake_survey());
  const PictureExtent picture{2, 16, 24};
  std::vector<NetworkConfig> graphs;
  for (size_t i = 0; i < 6; ++i) graphs.push_back(space[i].config.network);
  const CostModel costs(graphs, picture, 1);
  for (const Candidate& candidate : space) {
    const NetworkTime time = measure_network(random_weights(candidate.config.network), picture, 1);
    EXPECT_GT(time.ms, 0) << candidate.name;
    EXPECT_GT(measure_network(random_weights_in_eight_bits(candidate.config.network), picture, 1).ms, 0);
    EXPECT_GT(time.memory_mb, 0) << candidate.name;
    EXPECT_GT(costs.milliseconds(candidate.config.network, picture), 0) << candidate.name;
  }
}

TEST(TuningCost, PredictionsGrowWithThePictureAndTheNetwork) {
  const std::vector<Candidate> space = candidate_space({}, fake_survey());
  const auto network = [&](const std::string& name) {
    return std::find_if(space.begin(), space.end(), [&](const Candidate& c) { return c.name == name; })
        ->config.network;
  };
  std::vector<NetworkConfig> graphs;
  for (size_t i = 0; i < 6; ++i) graphs.push_back(space[i].config.network);
  CostModel costs(graphs, {2, 32, 32}, 1);
  const double small = costs.milliseconds(network("layer2_small_k9"), {2, 64, 64});
  EXPECT_GT(costs.milliseconds(network("layer2_fine_k9"), {2, 64, 64}), 2 * small);
  EXPECT_NEAR(costs.milliseconds(network("layer2_small_k9"), {2, 128, 64}), 2 * small, 1e-6 * small);
  EXPECT_EQ(CostModel(costs.rates()).milliseconds(network("layer2_small_k9"), {2, 64, 64}), small);
}

}  // namespace
}  // namespace ld
