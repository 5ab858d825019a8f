// The registry: configurations, sizes, initial weights.
#include "models/initialise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "graph/extent.h"
#include "models/graphs/network_graph.h"
#include "tests/models/small_network.h"

namespace ld {
namespace {

TEST(Network, ThePublishedConfigurationHasItsParameters) {
  const auto network = make_network(NetworkConfig());
  int64_t count = 0;
  for (const auto& parameter : network->parameters()) count += parameter.numel();
  // Counted by hand from figure 3 and appendix B: weights and biases of reducer 2784, partitioner 5714,
  // kernel generator 74401, U-net 17197056 + 4480. The published network has 17.28 M.
  EXPECT_EQ(count, 2784 + 5714 + 74401 + 17197056 + 4480);
  EXPECT_NEAR(double(count) / 1e6, 17.28, 0.005);
}

TEST(Network, XavierWeightsHaveTheirBoundAndVariance) {
  const auto network = make_network(NetworkConfig());
  initialise(*network, 7);
  for (const auto& entry : network->named_parameters()) {
    const torch::Tensor p = entry.value().detach().to(torch::kFloat64);
    if (p.dim() == 1) {
      EXPECT_TRUE(p.eq(0).all().item<bool>()) << entry.key();
      continue;
    }
    const double taps = p.dim() == 4 ? 9 : 1, sum = taps * double(p.size(0) + p.size(1)),
                 n = double(p.numel());
    EXPECT_LE(p.abs().max().item<double>(), std::sqrt(6 / sum) * (1 + 1e-6)) << entry.key();
    // Five deviations of the estimates: of a uniform variance (relative sqrt(0.8 / n)) and of the mean.
    const double variance = p.square().mean().item<double>();
    EXPECT_NEAR(variance * sum / 2, 1, 5 * std::sqrt(0.8 / n)) << entry.key();
    EXPECT_NEAR(p.mean().item<double>(), 0, 5 * std::sqrt(2 / sum / n)) << entry.key();
  }
}

TEST(Network, TheSameSeedGivesTheSameBits) {
  const auto a = make_network(small_config()), b = make_network(small_config()),
             c = make_network(small_config());
  initialise(*a, 1);
  initialise(*b, 1);
  initialise(*c, 2);
  for (const auto& entry : a->named_parameters()) {
    EXPECT_TRUE(entry.value().equal(b->named_parameters()[entry.key()])) << entry.key();
    if (entry.value().dim() > 1) {
      EXPECT_FALSE(entry.value().equal(c->named_parameters()[entry.key()])) << entry.key();
    }
  }
  // Two weights of the same shape are not copies of one another.
  const auto parameters = a->named_parameters();
  EXPECT_FALSE(parameters["unet.encoder0.2.weight"].equal(parameters["unet.encoder0.0.weight"]));
}

TEST(Network, ParametersAreNamedAfterTheBoxes) {
  std::vector<std::string> names;
  for (const auto& entry : make_network(small_config())->named_parameters()) names.push_back(entry.key());
  for (const char* name : {"sample_reducer.0.weight", "sample_reducer.1.bias", "unet.encoder0.0.weight",
                           "unet.bottleneck.0.bias", "unet.decoder1.2.weight", "unet.context.weight",
                           "sample_partitioner.1.weight", "kernel_generator.0.bias"})
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
}

void expect_usage_error(const NetworkConfig& config, const std::string& part) {
  try {
    make_network(config);
    ADD_FAILURE() << "accepted a configuration that should say: " << part;
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(Network, SizesThatDoNotFitAreUsageErrors) {
  NetworkConfig config = small_config();
  config.name = "layr";
  expect_usage_error(config, "did you mean 'layer'");
  config = small_config();
  config.features.push_back("norml");
  expect_usage_error(config, "did you mean 'normal'");
  config = small_config();
  config.features.push_back("normal");
  expect_usage_error(config, "'normal' twice");
  config = small_config();
  config.features.back() = "id";
  expect_usage_error(config, "the feature 'id' is for filters");
  config.features.clear();
  expect_usage_error(config, "network.features is empty");
  config = small_config();
  config.kernel_size = 4;
  expect_usage_error(config, "network.kernel_size is 4");
  config = small_config();
  config.layers = 0;
  expect_usage_error(config, "network.layers is 0");
  config = small_config();
  config.compositing = "beta";
  expect_usage_error(config, "network.compositing 'beta'");
  config = small_config();
  config.sample_reducer.clear();
  expect_usage_error(config, "network.sample_reducer is empty");
  config = small_config();
  config.kernel_generator = {8, 0};
  expect_usage_error(config, "network.kernel_generator has a width of 0");
  config = small_config();
  config.unet.decoder.pop_back();
  expect_usage_error(config, "network.unet.encoder has 2 blocks and network.unet.decoder 1");
  config = small_config();
  config.unet.encoder[1].clear();
  expect_usage_error(config, "network.unet.encoder is empty");
  config = small_config();
  config.unet.encoder.clear();
  config.unet.decoder.clear();
  expect_usage_error(config, "at least one block");
  config = small_config();
  config.unet.bottleneck.clear();
  expect_usage_error(config, "network.unet.bottleneck is empty");
  config = small_config();
  config.unet.context = 0;
  expect_usage_error(config, "network.unet.context");
  config = small_config();
  config.name = "pixel_gather";
  config.compositing = "weighted";
  expect_usage_error(config, "network 'pixel_gather' has no layers to composite");
  config = small_config();
  config.name = "sample_splat";
  config.layers = 3;
  expect_usage_error(config, "network.layers is 3, but network 'sample_splat' has no layers");
  config = small_config();
  config.levels = 2;
  expect_usage_error(config, "network.levels is 2, but network 'layer' works at one resolution");
  config = small_config();
  config.name = "optimized";
  config.levels = 4;
  expect_usage_error(config, "network.levels is 4, expected 1 to 3");
  config = small_config();
  config.unet.upsampling = "cubic";
  expect_usage_error(config, "network.unet.upsampling 'cubic'");
}

TEST(Network, ParametersAreThoseOfItsGraph) {
  for (const NetworkConfig& config : every_config()) {
    const graph::Graph graph = network_graph(config);
    const auto made = make_network(config)->named_parameters();
    int64_t count = 0;
    for (const graph::Parameter& parameter : graph::parameters(graph)) {
      ASSERT_NE(made.find(parameter.name), nullptr) << title(config) << " " << parameter.name;
      EXPECT_EQ(made[parameter.name].sizes(), parameter.shape) << title(config) << " " << parameter.name;
      count += made[parameter.name].numel();
    }
    EXPECT_EQ(made.size(), graph::parameters(graph).size()) << title(config);
    EXPECT_EQ(graph::parameter_count(graph), count) << title(config);
  }
  NetworkConfig absurd;  // more than 1 TB
  absurd.unet.encoder.assign(10, std::vector<int64_t>(100, 4096));
  absurd.unet.decoder = absurd.unet.encoder;
  EXPECT_GT(graph::parameter_count(network_graph(absurd)), int64_t(1) << 38);
}

TEST(Network, AnAbsurdNumberOfWidthsIsNamed) {
  NetworkConfig config = small_config();
  config.sample_reducer.assign(5000, 4);
  expect_usage_error(config, "network.sample_reducer has 5000 widths, expected at most 100");
}

TEST(Network, EveryNetworkDenoisesAndTrains) {
  for (const NetworkConfig& config : every_config()) {
    const auto network = make_network(config);
    initialise(*network, 3);
    const NetworkInput input = random_input(config, 2, 3, 6, 5, torch::kFloat32);
    const torch::Tensor output = network->forward(input);
    EXPECT_EQ(output.sizes(), (std::vector<int64_t>{2, 3, 6, 5})) << title(config);
    output.square().sum().backward();
    for (const auto& entry : network->named_parameters()) {
      ASSERT_TRUE(entry.value().grad().defined()) << title(config) << " " << entry.key();
      EXPECT_TRUE(all_finite(entry.value().grad())) << title(config) << " " << entry.key();
      if (entry.key().rfind("history.", 0) == 0) continue;  // a first frame has none (history_test.cpp)
      EXPECT_GT(entry.value().grad().abs().max().item<double>(), 0) << title(config) << " " << entry.key();
    }
  }
}

}  // namespace
}  // namespace ld
