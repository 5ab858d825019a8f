// Every network against plain loops in double, and its gradients against finite differences.
#include <gtest/gtest.h>

#include "losses/loss.h"
#include "models/sample_statistics.h"
#include "tests/models/small_network.h"
#include "tests/support/gradient_check.h"
#include "tests/support/plain_losses.h"
#include "tests/support/scalar_networks.h"

namespace ld {
namespace {

using torch::Tensor;

Tensor expected_output(const Network& network, const NetworkInput& input) {
  reference::Parameters parameters;
  for (const auto& entry : network.named_parameters()) {
    const Tensor p = entry.value().detach().to(torch::kFloat64).contiguous();
    parameters[entry.key()] = {p.sizes().vec(), {p.data_ptr<double>(), p.data_ptr<double>() + p.numel()}};
  }
  reference::NetworkLayout layout;
  const NetworkConfig& config = network.config();
  for (const auto& block : config.unet.encoder) layout.unet.encoder.push_back(int64_t(block.size()));
  for (const auto& block : config.unet.decoder) layout.unet.decoder.push_back(int64_t(block.size()));
  layout.unet.bottleneck = int64_t(config.unet.bottleneck.size());
  layout.unet.bilinear = config.unet.upsampling == "bilinear";
  layout.weighted = config.compositing == "weighted";
  layout.levels = config.levels;
  layout.kernel_size = config.kernel_size;
  layout.logit_bound = config.logit_bound;
  layout.demodulates = config.demodulation != "none";
  layout.rejects = config.rejection;
  layout.albedo = first_channel(config.features, "albedo");
  layout.specular = first_channel(config.features, "specular");
  layout.radiance = first_channel(config.features, "radiance");
  layout.convolutions = int64_t(config.super_resolution.convolutions.size());
  layout.tanh = config.super_resolution.activation == "tanh";
  layout.reads_light = config.super_resolution.light();
  layout.reads_guides = config.super_resolution.guides();
  const reference::Samples samples = {to_grid(input.features), to_grid(input.radiance), to_grid(input.valid)};
  return to_tensor(reference::network(config.name, samples, parameters, layout)).squeeze(1);
}

void expect_reference(const NetworkConfig& config, int64_t samples, int64_t h, int64_t w) {
  const NetworkInput input = random_input(config, 2, samples, h, w, torch::kFloat64);
  const auto network = small_network(config, torch::kFloat64);
  const Tensor expected = expected_output(*network, input);
  EXPECT_GT(expected.abs().sum().item<double>(), 0);
  EXPECT_LE(largest_difference(network->forward(input), expected), 1e-10)
      << title(config) << " " << samples << " spp, " << h << "x" << w;
  // Logits of order 1 behind some ten layers, values up to 4.
  network->to(torch::kFloat32);
  EXPECT_LE(largest_difference(network->forward(to_type(input, torch::kFloat32)), expected), 4e-5 * 4)
      << title(config) << " " << samples << " spp, " << h << "x" << w;
}

TEST(NetworkReference, EveryNetworkAgreesWithPlainLoops) {
  for (NetworkConfig config : every_config())
    for (const int64_t samples : {1, 3, 8})
      for (const auto& [h, w] : std::vector<std::pair<int64_t, int64_t>>{{1, 1}, {1, 2}, {5, 7}, {9, 6}}) {
        config.kernel_size = samples == 3 ? 5 : 3;
        config.unet.upsampling = samples == 8 ? "nearest" : "bilinear";
        expect_reference(config, samples, h, w);
      }
}

TEST(NetworkReference, AnyNumberOfLayersAgreesWithPlainLoops) {
  for (NetworkConfig config : every_config())
    for (const int64_t layers : {1, 3, 8}) {
      if (!has_layers(config)) continue;
      config.layers = layers;
      expect_reference(config, 3, 5, 7);
    }
}

TEST(NetworkReference, AnyNumberOfLevelsAgreesWithPlainLoops) {
  for (NetworkConfig config : every_config()) {
    if (!network_traits(config.name).has_levels) continue;
    config.unet.encoder = {{4}, {5}, {6}};
    config.unet.decoder = {{6}, {5}, {4}};
    for (const int64_t levels : {1, 2, 4}) {
      config.levels = levels;
      expect_reference(config, 3, 11, 9);
    }
  }
}

// The last row of pixels alone has samples: coarse levels reach further than fine ones.
TEST(NetworkReference, PartsOfThePictureWithoutSamplesAgreeWithPlainLoops) {
  for (const NetworkConfig& config : every_config()) {
    NetworkInput input = random_input(config, 1, 3, 13, 9, torch::kFloat64);
    input.valid.narrow(3, 0, 12).zero_();
    const auto network = small_network(config, torch::kFloat64);
    EXPECT_LE(largest_difference(network->forward(input), expected_output(*network, input)), 1e-10)
        << title(config);
  }
}

TEST(NetworkReference, GradientsAgreeWithFiniteDifferences) {
  for (const NetworkConfig& config : every_config()) {
    SCOPED_TRACE(title(config));
    const auto network = small_network(config, torch::kFloat64);
    const NetworkInput input = random_input(config, 1, 3, 5, 6, torch::kFloat64);
    const Tensor reference_image = random_uniform({1, 3, 5, 6}, 7, 0, 4);
    std::vector<Tensor> inputs = network->parameters();
    inputs.push_back(variable(input.features));
    inputs.push_back(variable(input.radiance));
    const size_t count = inputs.size();
    const auto run = [&](const std::vector<Tensor>& v) {
      return network->forward({v[count - 2], v[count - 1], input.valid});
    };
    expect_gradients(run, inputs, 8);
    for (const std::string& name : plain_losses())
      expect_gradients([&](const auto& v) { return make_loss(name)(run(v), reference_image); }, inputs, 1);
  }
}

TEST(SampleStatistics, AgreeWithPlainLoopsAndTheirGradients) {
  for (const int64_t samples : {1, 2, 7}) {
    const Tensor features = variable(random_normal({2, samples, 3, 4, 5}, 1)),
                 valid = random_valid(2, samples, 4, 5, 2);
    const Tensor expected = to_tensor(reference::statistics(to_grid(features), to_grid(valid)));
    EXPECT_LE(largest_difference(sample_statistics(features, valid), expected), 1e-12);
    expect_gradients([&](const auto& v) { return sample_statistics(v[0], valid); }, {features});
  }
}

TEST(SampleStatistics, TheVarianceSurvivesALargeMean) {
  for (const int64_t samples : {3, 8, 64}) {
    const Tensor features = (random_normal({1, samples, 4, 9, 11}, 3) + 6e4).to(torch::kFloat32);
    const Tensor valid = torch::ones({1, samples, 1, 9, 11});
    const Tensor exact = to_tensor(reference::statistics(to_grid(features), to_grid(valid)));
    const Tensor variance = sample_statistics(features, valid).narrow(2, 4, 4).to(torch::kFloat64);
    EXPECT_LE((variance / exact.narrow(2, 4, 4) - 1).abs().max().item<double>(), 1e-4) << samples;
  }
}

TEST(SampleStatistics, OneSampleHasNoVarianceAndDuplicatesChangeNothing) {
  const Tensor features = (random_normal({1, 3, 4, 5, 6}, 4) + 1e3).to(torch::kFloat32),
               valid = random_valid(1, 3, 5, 6, 5).to(torch::kFloat32);
  EXPECT_TRUE(sample_statistics(features.narrow(1, 0, 1), valid.narrow(1, 0, 1))
                  .narrow(2, 4, 4)
                  .eq(0)
                  .all()
                  .item<bool>());
  expect_near(sample_statistics(at::cat({features, features}, 1), at::cat({valid, valid}, 1)),
              sample_statistics(features, valid), 1e-6);
}

}  // namespace
}  // namespace ld
