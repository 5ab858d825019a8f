// Every file of configs/ is a network that can be made and a training that can start.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "graph/extent.h"
#include "losses/loss.h"
#include "models/graphs/network_graph.h"
#include "models/network.h"
#include "training/run/config_file.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

std::map<std::string, TrainConfig> all_configs() {
  std::map<std::string, TrainConfig> configs;
  for (const auto& file : fs::directory_iterator(fs::path(LD_SOURCE_DIR) / "configs"))
    if (file.path().extension() == ".yaml") {
      const TrainConfig config = read_train_config(file.path());
      if (!config.network.of_init()) configs[file.path().stem().string()] = config;
    }
  return configs;
}

int64_t numbers_of(const NetworkConfig& config) {
  return graph::parameter_count(network_graph(config));
}

TEST(Configs, EveryFileIsATraining) {
  const auto configs = all_configs();
  EXPECT_GE(configs.size(), 13U);
  for (const auto& [name, config] : configs) {
    SCOPED_TRACE(name);
    EXPECT_NO_THROW(make_network(config.network));
    EXPECT_NO_THROW(make_loss(config.loss));
    const NetworkConfig reread =
        config_from_tree<NetworkConfig>(parse_config(config_to_yaml(config.network), name));
    EXPECT_EQ(config_to_yaml(reread), config_to_yaml(config.network));
  }
}

TEST(Configs, EveryNetworkHasAPublishedAndASmallOne) {
  const auto configs = all_configs();
  for (const std::string& name : network_names()) {
    ASSERT_EQ(configs.count(name), 1U) << name;
    EXPECT_EQ(configs.at(name).network.name, name);
    const std::string quick = name == "layer" ? "quick" : "quick_" + name;
    ASSERT_EQ(configs.count(quick), 1U) << quick;
    EXPECT_EQ(configs.at(quick).network.name, name);
    // One for real time is small already.
    EXPECT_LT(numbers_of(configs.at(quick).network),
              std::max<int64_t>(numbers_of(configs.at(name).network) / 30, 20000));
  }
  EXPECT_EQ(configs.at("layer_weighted").network.compositing, "weighted");
  EXPECT_EQ(configs.at("quick_layer_weighted").network.compositing, "weighted");
}

// Counted by hand from figure 3, section 6 and appendix B, weights and biases.
TEST(Configs, PublishedNetworksHaveTheirParameters) {
  const int64_t reducer = 2784, pixel_reducer = 3424, partitioner = 5714, generator = 74401,
                unet = 17197056 + 4480;
  const int64_t optimized_unet = 16537600, optimized_partitioner = 3666,
                optimized_generators = 5084 + 4985 + 7033;  // of full, half and quarter resolution
  const std::map<std::string, int64_t> expected = {
      // 43 channels at half resolution, 13 at full.
      {"espcn_kpcn", (43 * 25 * 64 + 64) + (64 * 9 * 32 + 32) + (32 * 9 * 12 + 12) + (13 * 9 * 32 + 32) +
                         (32 * 9 * 32 + 32) + (32 * 9 * 9 + 9)},
      {"layer", reducer + unet + partitioner + generator},
      {"layer_published_code", reducer + unet + partitioner + generator},
      {"layer_weighted", reducer + unet + partitioner + generator},
      {"sample_splat", reducer + unet + generator},
      {"pixel_gather", pixel_reducer + unet + generator},
      {"pixel_splat", pixel_reducer + unet + generator},
      {"recurrent", 1951935},
      {"optimized", reducer + optimized_unet + optimized_partitioner + optimized_generators}};
  const auto configs = all_configs();
  for (const auto& [name, count] : expected) EXPECT_EQ(numbers_of(configs.at(name).network), count) << name;
}

// The networks of a comparison are trained alike: same features, loss, data, optimiser.
TEST(Configs, NetworksDifferInTheirNetworkAlone) {
  const auto configs = all_configs();
  for (const auto& [base, prefix] : std::map<std::string, std::string>{{"layer", ""}, {"quick", "quick_"}})
    for (const char* name : {"layer_weighted", "sample_splat", "pixel_gather", "pixel_splat", "optimized"}) {
      TrainConfig config = configs.at(prefix + name);
      EXPECT_EQ(config.network.features, configs.at(base).network.features);
      EXPECT_EQ(config.network.sample_reducer, configs.at(base).network.sample_reducer);
      config.network = configs.at(base).network;
      EXPECT_EQ(config_to_yaml(config), config_to_yaml(configs.at(base))) << prefix << name;
    }
}

}  // namespace
}  // namespace ld
