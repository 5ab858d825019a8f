// What a training's watch sees of the kernels.
#include "training/kernel_statistics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "models/initialise.h"
#include "tests/models/small_network.h"

namespace ld {
namespace {

/// The network with the last layer of its kernel generators set to these logits, the same in all pixels.
std::shared_ptr<Network> with_logits(const NetworkConfig& config, double centre, double others) {
  const auto network = small_network(config, torch::kFloat32);
  const torch::NoGradGuard no_gradient;
  for (auto& entry : network->named_parameters()) {
    const std::string& name = entry.key();
    if (name.rfind("kernel_generator", 0) != 0 || name.find(".1.") == std::string::npos) continue;
    entry.value().zero_();
    if (name.find("bias") == std::string::npos) continue;
    entry.value().fill_(others);
    entry.value()[4] = centre;
  }
  return network;
}

TEST(KernelStatistics, KnowsEqualTapsOneTapAndOneKernelEverywhere) {
  for (const NetworkConfig& config : every_config()) {
    if (!generates_kernels(config)) continue;
    SCOPED_TRACE(title(config));
    NetworkInput input = random_input(config, 2, 3, 7, 6, torch::kFloat32);
    const KernelStatistics box = kernel_statistics(*with_logits(config, 0, 0), input);
    EXPECT_NEAR(box.entropy, std::log(9), 1e-5);
    EXPECT_NEAR(box.centre_share, 1.0 / 9, 1e-5);
    double sum = 0;
    for (const double share : box.layer_share) sum += share;
    EXPECT_EQ(box.layer_share.size(), has_layers(config) ? size_t(config.layers) : 0U);
    if (has_layers(config)) {
      EXPECT_NEAR(sum, 1, 1e-6);
    }
    if (config.logit_bound == 0) {
      const KernelStatistics one = kernel_statistics(*with_logits(config, 40, 0), input);
      EXPECT_GE(one.entropy, 0);  // a watch whose limit is 0 must not see less
      EXPECT_LT(one.entropy, 1e-9);
      EXPECT_NEAR(one.centre_share, 1, 1e-6);
    }
    // Only what differs between layers or samples is left to deviate; with one of them, nothing.
    input.valid.fill_(1);
    const KernelStatistics learnt = kernel_statistics(*small_network(config, torch::kFloat32), input);
    EXPECT_GT(learnt.deviation, 1e-3);
    if (works_on_pixels(config)) {
      EXPECT_LT(kernel_statistics(*with_logits(config, 1, 0), input).deviation, 1e-6);
    }
  }
}

TEST(KernelStatistics, APictureWithoutSamplesHasNone) {
  const NetworkConfig config = small_config();
  NetworkInput input = random_input(config, 1, 2, 4, 4, torch::kFloat32);
  input.valid.zero_();
  EXPECT_EQ(kernel_statistics(*small_network(config, torch::kFloat32), input).entropy, 0);
}

TEST(KernelStatistics, AreMeansOverProcessesAndColumnsOfTheTable) {
  ProcessGroup alone{ProcessGroupOptions{}};
  const KernelStatistics half = mean_over_processes({2, 0.5, {0.75, 0.25}, 0.125}, 0.5, alone);
  EXPECT_EQ(half.deviation, 0.0625);
  std::map<std::string, double> row = {{"smape", 3}};
  add_to_row(half, row);
  EXPECT_EQ(row, (std::map<std::string, double>{{"kernel_centre_share", 0.25},
                                                {"kernel_entropy", 1},
                                                {"kernel_layer_share_1", 0.375},
                                                {"kernel_layer_share_2", 0.125},
                                                {"smape", 3}}));
}

}  // namespace
}  // namespace ld
