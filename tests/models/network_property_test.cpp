// What must hold for every network with any weights.
#include <gtest/gtest.h>

#include <numeric>

#include "tests/models/small_network.h"

namespace ld {
namespace {

using torch::Tensor;

/// Configurations with layers also with many of them.
std::vector<NetworkConfig> with_layer_counts(const std::vector<int64_t>& counts) {
  std::vector<NetworkConfig> configs;
  for (NetworkConfig config : every_config())
    if (has_layers(config)) {
      for (const int64_t layers : counts) {
        config.layers = layers;
        configs.push_back(config);
      }
    } else {
      configs.push_back(config);
    }
  return configs;
}

TEST(NetworkProperty, AConstantImageStaysConstantWithAnyWeights) {
  for (NetworkConfig config : with_layer_counts({1, 2, 3, 5, 8})) {
    if (!averages(config.name)) continue;
    config.kernel_size = 5;
    for (const double scale : {1.0, 30.0, 1e3, 1e4}) {
      const auto network = small_network(config, torch::kFloat32);
      scale_logits(*network, scale);
      for (const auto& [h, w] : std::vector<std::pair<int64_t, int64_t>>{{9, 11}, {1, 1}, {2, 7}}) {
        NetworkInput input = with_one_reflectance(random_input(config, 1, 3, h, w, torch::kFloat32), config);
        if (h * w == 1) input.valid.fill_(1);
        input.radiance = (input.valid * 2.5).expand({1, 3, 3, h, w}).contiguous();
        const torch::NoGradGuard no_graph;
        EXPECT_LE((network->forward(input) / 2.5 - 1).abs().max().item<double>(), 1e-5)
            << title(config) << " scale " << scale << " " << h << "x" << w;
      }
    }
  }
}

// Most of the picture has no samples: a pixel is either constant or out of reach of all kernels.
TEST(NetworkProperty, AConstantStaysWhereverASampleIsInReach) {
  for (const NetworkConfig& config : every_config()) {
    if (!averages(config.name)) continue;
    const auto network = small_network(config, torch::kFloat32);
    scale_logits(*network, 1e3);
    NetworkInput input = with_one_reflectance(random_input(config, 1, 3, 33, 29, torch::kFloat32), config);
    input.valid.fill_(1);
    input.valid.narrow(3, 3, 30).zero_();
    input.radiance = (input.valid * 2.5).expand({1, 3, 3, 33, 29}).contiguous();
    const torch::NoGradGuard no_graph;
    const Tensor output = network->forward(input);
    // The 3x3 kernels reach one pixel of their level (at a quarter: rows 4 to 7 beside row 3); bilinear
    // upscaling reads one more.
    const bool levels = network_traits(config.name).has_levels;
    const int64_t near = levels ? 8 : 4, far = levels ? 12 : 4;
    EXPECT_LE((output.narrow(2, 0, near) / 2.5 - 1).abs().max().item<double>(), 1e-5) << title(config);
    EXPECT_TRUE(output.narrow(2, far, 33 - far).eq(0).all().item<bool>()) << title(config);
  }
}

TEST(NetworkProperty, TheOrderOfSamplesChangesOnlyRounding) {
  for (const NetworkConfig& config : every_config()) {
    const auto network = small_network(config, torch::kFloat32);
    const NetworkInput input = random_input(config, 1, 5, 7, 8, torch::kFloat32);
    const torch::NoGradGuard no_graph;
    SCOPED_TRACE(title(config));
    expect_near(network->forward(select_samples(input, {3, 0, 4, 2, 1})), network->forward(input), 2e-5);
  }
}

TEST(NetworkProperty, DuplicatedSamplesChangeOnlyRounding) {
  for (const NetworkConfig& config : every_config()) {
    const auto network = small_network(config, torch::kFloat32);
    const NetworkInput input = random_input(config, 1, 3, 7, 8, torch::kFloat32);
    const torch::NoGradGuard no_graph;
    SCOPED_TRACE(title(config));
    expect_near(network->forward(select_samples(input, {0, 1, 2, 0, 1, 2})), network->forward(input), 2e-5);
  }
}

TEST(NetworkProperty, EverySizeAndSampleCount) {
  for (const NetworkConfig& config : every_config()) {
    const auto network = small_network(config, torch::kFloat32);
    const torch::NoGradGuard no_graph;
    for (const auto& [h, w] :
         std::vector<std::pair<int64_t, int64_t>>{{1, 1}, {1, 2}, {2, 1}, {31, 33}, {4, 4}, {1080, 3}})
      for (const int64_t samples : {1, 2, 8, 64}) {
        if (h > 1000 && samples > 2) continue;  // the height is what is new
        NetworkInput input =
            with_one_reflectance(random_input(config, 1, samples, h, w, torch::kFloat32), config);
        input.valid.select(1, 0).fill_(1);
        const Tensor output = network->forward(input);
        EXPECT_EQ(output.sizes(), (std::vector<int64_t>{1, 3, h, w})) << title(config);
        EXPECT_TRUE(all_finite(output)) << title(config) << " " << h << "x" << w << " " << samples;
        EXPECT_GE(output.min().item<double>(), 0) << title(config);
        if (!averages(config.name)) continue;
        // Kernels only average: the result lies within the radiance that there is.
        EXPECT_LE(output.max().item<double>(), input.radiance.max().item<double>() * (1 + 1e-5));
      }
  }
}

// One frame whose pixels hold 0 to 64 samples, and the same frame with the empty samples at other places.
TEST(NetworkProperty, SampleCountsMayDifferWithinAFrame) {
  for (const NetworkConfig& config : every_config()) {
    const auto network = small_network(config, torch::kFloat32);
    NetworkInput input = random_input(config, 1, 64, 9, 13, torch::kFloat32);
    const Tensor drawn = torch::arange(64).view({1, 64, 1, 1, 1}),
                 count = torch::arange(9 * 13).view({1, 1, 1, 9, 13}).remainder(65);
    input.valid = drawn.lt(count).to(torch::kFloat32);
    std::vector<int64_t> reversed(64);
    std::iota(reversed.rbegin(), reversed.rend(), 0);
    const torch::NoGradGuard no_graph;
    const Tensor output = network->forward(input);
    EXPECT_TRUE(all_finite(output)) << title(config);
    SCOPED_TRACE(title(config));
    expect_near(network->forward(select_samples(input, reversed)), output, 5e-5);
  }
}

TEST(NetworkProperty, ThreeRunsGiveTheSameBits) {
  const int threads = at::get_num_threads();
  for (NetworkConfig config : every_config()) {
    config.kernel_size = 9;
    const NetworkInput input = random_input(config, 2, 4, 17, 19, torch::kFloat32);
    for (const int count : {1, 2}) {
      at::set_num_threads(count);
      std::vector<Tensor> first;
      for (int repeat = 0; repeat < 3; ++repeat) {
        const auto network = small_network(config, torch::kFloat32);
        const Tensor output = network->forward(input);
        output.square().mean().backward();
        std::vector<Tensor> results = {output};
        for (const auto& parameter : network->parameters()) results.push_back(parameter.grad());
        if (repeat == 0) first = results;
        for (size_t i = 0; i < results.size(); ++i)
          EXPECT_TRUE(results[i].equal(first[i])) << title(config) << " " << count << " threads, " << i;
      }
    }
  }
  at::set_num_threads(threads);
}

// Without gradients convolutions and filters run otherwise; what they compute is the same.
TEST(NetworkProperty, WithoutGradientsThePictureIsThatOfTraining) {
  for (NetworkConfig config : every_config())
    for (const char* upsampling : {"bilinear", "nearest"}) {
      config.unet.upsampling = upsampling;
      const auto network = small_network(config, torch::kFloat64);
      const NetworkInput input = random_input(config, 1, 3, 61, 37, torch::kFloat64);
      const Tensor trained = network->forward(input).detach();
      const c10::InferenceMode guard;
      EXPECT_LE(largest_difference(network->forward(input), trained), 1e-12)
          << title(config) << " " << upsampling;
    }
}

}  // namespace
}  // namespace ld
