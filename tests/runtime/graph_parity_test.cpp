// The runtime against the networks that it stands for, in LibTorch.
#include <gtest/gtest.h>

#include "dataset/input_tensors.h"
#include "models/exposure.h"
#include "ops/kernels/instruction_sets.h"
#include "runtime/sample_source.h"
#include "tests/runtime/graph_cases.h"
#include "tests/runtime/run_graph.h"

namespace ld {
namespace {

void scale_light(Frame& frame, float factor) {
  for (int s = 0; s < frame.spp; ++s)
    for (int c = 0; c < 3; ++c)
      for (size_t p = 0; p < frame.plane_size(); ++p) frame.plane(s, kRadianceOffset + c)[p] *= factor;
}

Image in_torch(Network& network, const Frame& frame) {
  const torch::NoGradGuard no_graph;
  return to_image(network.forward(make_network_input({frame}, network.config().features)).squeeze(0));
}

float largest_difference(const Image& a, const Image& b) {
  float most = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) most = std::max(most, std::fabs(a.pixels[i] - b.pixels[i]));
  return most;
}

TEST(GraphParity, TheGraphGivesThePictureOfTheNetwork) {
  for (const NetworkConfig& config : graph_configs())
    for (const auto& [width, height, spp] :
         {std::tuple(1, 1, 1), std::tuple(7, 5, 3), std::tuple(33, 70, 2), std::tuple(131, 37, 1),
          std::tuple(16, 16, 64), std::tuple(461, 40, 1)}) {
      const auto network = small_network(config, torch::kFloat32);
      const Frame frame = uneven_frame(width, height, spp);
      const Image expected = in_torch(*network, frame);
      const float largest = *std::max_element(expected.pixels.begin(), expected.pixels.end());
      const Image found = in_runtime(config, weights_of(*network), frame, {});
      EXPECT_LE(largest_difference(found, expected), 1e-5F * largest)
          << full_title(config) << ", " << width << " x " << height << " at " << spp;
    }
}

// Sums over 1024 channels; wide enough for tiles (runtime/steps_unet.cpp) where the U-net has these.
TEST(GraphParity, AtThePublishedWidths) {
  const Frame frame = uneven_frame(400, 24, 2);
  for (const std::string& name : network_names()) {
    NetworkConfig config;
    config.name = name;
    const auto network = small_network(config, torch::kFloat32);
    const Image expected = in_torch(*network, frame);
    const float largest = *std::max_element(expected.pixels.begin(), expected.pixels.end());
    const float difference =
        largest_difference(in_runtime(config, weights_of(*network), frame, {2}), expected);
    RecordProperty(name, std::to_string(difference / largest));
    EXPECT_LE(difference, 1e-5F * largest) << full_title(config);
  }
}

TEST(GraphParity, WhateverTheUnitsOfTheLight) {
  for (const NetworkConfig& config : graph_configs())
    for (const float factor : {1e-30F, 1e30F, 1e36F}) {
      const auto network = small_network(config, torch::kFloat32);
      Frame frame = uneven_frame(23, 17, 2);
      scale_light(frame, factor);
      const Image expected = in_torch(*network, frame);
      const float largest = *std::max_element(expected.pixels.begin(), expected.pixels.end());
      ASSERT_GT(largest, 0);
      const Image found = in_runtime(config, weights_of(*network), frame, {});
      EXPECT_LE(largest_difference(found, expected), 1e-5F * largest)
          << full_title(config) << ", light times " << factor;
    }
}

/// With radiance of half resolution, of a picture of its own.
Frame half_lit_frame(int width, int height, int spp) {
  const Frame plain = uneven_frame(width, height, spp),
              half = uneven_frame((width + 1) / 2, (height + 1) / 2, spp);
  Frame frame(width, height, spp, kAllChannels);
  frame.info = plain.info;
  frame.valid = plain.valid;
  for (int s = 0; s < spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p) {
      for (int c = 0; c < kSampleChannels; ++c) frame.plane(s, c)[p] = plain.plane(s, c)[p];
      const size_t from = p / size_t(width) / 2 * size_t(half.width) + p % size_t(width) / 2;
      for (int c = 0; c < 3 && frame.valid_plane(s)[p] != 0; ++c) {
        frame.plane(s, kHalfRadianceOffset + c)[p] = half.plane(s, c)[from];
        frame.plane(s, kPositionOffset + c)[p] = plain.plane(s, kNormalOffset + c)[p];
      }
    }
  frame.features = plain.features;
  for (const char* name : {"half_radiance", "position"}) frame.features.emplace_back(name);
  return frame;
}

TEST(GraphParity, OfSuperResolutionInAllItsForms) {
  for (const std::vector<std::string>& features :
       {std::vector<std::string>{"half_radiance", "position", "normal", "albedo", "roughness"},
        {"albedo", "half_radiance"},
        {"albedo", "depth", "radiance", "specular"}})
    for (const char* reads : {"light", "guides", "both"})
      for (const bool demodulates : {false, true})
        for (const auto& [width, height, spp] :
             {std::tuple(1, 1, 1), std::tuple(7, 5, 3), std::tuple(34, 71, 2), std::tuple(1031, 6, 1)}) {
          NetworkConfig config = small_config();
          config.name = "espcn_kpcn";
          config.features = features;
          config.super_resolution.reads = reads;
          config.super_resolution.activation = demodulates ? "relu" : "tanh";
          if (demodulates) config.demodulation = "albedo";
          const auto network = small_network(config, torch::kFloat32);
          const Frame frame = half_lit_frame(width, height, spp);
          const Image expected = in_torch(*network, frame);
          const float largest = *std::max_element(expected.pixels.begin(), expected.pixels.end());
          if (width > 1) {  // the first pixel has no samples
            ASSERT_GT(largest, 0);
          }
          EXPECT_LE(largest_difference(in_runtime(config, weights_of(*network), frame, {}), expected),
                    1e-5F * largest)
              << features[0] << ", " << reads << (demodulates ? ", demodulating" : "") << ", " << width
              << " x " << height << " at " << spp;
        }
}

TEST(GraphParity, TheExposureIsThatOfTheNetworks) {
  Frame frame = uneven_frame(45, 39, 3);
  const auto in_networks = [&] {
    const NetworkInput input = make_network_input({frame}, {"radiance"});
    return exposure_of(input.radiance, input.valid)[0].item<double>();
  };
  const double exposure = frame_exposure(frame, 1);
  EXPECT_NEAR(exposure, in_networks(), 1e-12 * exposure);
  EXPECT_EQ(frame_exposure(frame, 2), exposure);
  scale_light(frame, std::exp2(-90.0F));
  EXPECT_EQ(frame_exposure(frame, 1), exposure * std::exp2(90.0));
  scale_light(frame, 0);
  EXPECT_EQ(frame_exposure(frame, 1), 1);
  EXPECT_EQ(in_networks(), 1);
}

TEST(GraphParity, OnEveryInstructionSet) {
  const NetworkConfig config = graph_configs()[1];
  const auto network = small_network(config, torch::kFloat32);
  const Frame frame = uneven_frame(45, 39, 4);
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    const Image expected = in_torch(*network, frame);
    const float largest = *std::max_element(expected.pixels.begin(), expected.pixels.end());
    EXPECT_LE(largest_difference(in_runtime(config, weights_of(*network), frame, {}), expected),
              1e-5F * largest)
        << set;
  }
  use_instruction_set("");
}

// Wide enough for several stretches of a splat, which take turns.
TEST(GraphParity, RowsAtATimeAndThreadsChangeNoBit) {
  for (const NetworkConfig& config : graph_configs()) {
    const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
    const Frame frame = uneven_frame(461, 40, 1);
    const Image expected = in_runtime(config, weights, frame, {});
    for (const int64_t block : {1, 16, 1000})
      for (const int threads : {1, 2})
        EXPECT_EQ(in_runtime(config, weights, frame, {threads, block}).pixels, expected.pixels)
            << full_title(config) << ", " << block << " rows, " << threads << " threads";
  }
}

TEST(GraphParity, APlanRunsManyFrames) {
  const NetworkConfig config = graph_configs()[1];
  const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
  const graph::Graph graph = network_graph(config);
  const Frame first = uneven_frame(20, 60, 2), second = random_frame(20, 60, 2, 3);
  Execution execution(graph, weights, {2, 60, 20}, {1, 16});
  const Image once = execution.run(first)[0];
  execution.run(second);
  EXPECT_EQ(execution.run(first)[0].pixels, once.pixels);
}

TEST(GraphParity, FewerRowsTakeLessMemory) {
  const NetworkConfig config = graph_configs()[0];
  const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
  const graph::Graph graph = network_graph(config);
  const auto bytes = [&](int64_t height, int64_t block) {
    return Execution(graph, weights, {2, height, 64}, {1, block}).arena_bytes();
  };
  EXPECT_LT(bytes(2000, 8), bytes(2000, 2000) / 10);
  EXPECT_EQ(bytes(2000, 8), bytes(4000, 8));  // whatever the height
}

}  // namespace
}  // namespace ld
