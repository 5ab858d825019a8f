// The recurrent autoencoder in the runtime against LibTorch's, and its state.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "dataset/input_tensors.h"
#include "frame/schema.h"
#include "tests/runtime/graph_cases.h"
#include "tests/runtime/run_graph.h"
#include "tests/support/expect_error.h"
#include "tests/support/moving_frame.h"

namespace ld {
namespace {

constexpr uint32_t kRecurrentFrames = 4;

/// Of three resolutions and of six, with what it may lack.
std::vector<NetworkConfig> recurrent_configs() {
  std::vector<NetworkConfig> configs = {small_recurrent_config()};
  NetworkConfig config = small_recurrent_config();
  config.features = {"albedo", "depth"};
  config.recurrence = false;
  config.unet.upsampling = "bilinear";
  configs.push_back(config);
  config = small_recurrent_config();
  config.features.emplace_back("radiance");
  config.unet.encoder = {{5, 6}, {7}, {8}, {9}, {10}};
  config.unet.bottleneck = {11};
  config.unet.decoder = {{9}, {8, 7}, {7}, {6}, {8, 5}};
  configs.push_back(config);
  return configs;
}

/// moving_frame() with what its surfaces emit, lamps, some rays that escaped, and missing samples.
Frame emitting_frame(int width, int height, int spp, uint32_t number) {
  const Frame from = moving_frame(width, height, spp, number);
  Frame frame(width, height, spp, kAllChannels);
  frame.features = from.features;
  frame.features.emplace_back("emission");
  frame.info = from.info;
  RandomStream random(190 + number, RandomPurpose::test);
  for (int s = 0; s < spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p) {
      const bool drawn = p % 11 != 3, escaped = random.uniform(0.0F, 1.0F) < 0.1F,
                 emits = random.uniform(0.0F, 1.0F) < 0.3F;
      frame.valid_plane(s)[p] = drawn ? 1 : 0;
      for (int c = 0; c < kSampleChannels; ++c) frame.plane(s, c)[p] = drawn ? from.plane(s, c)[p] : 0;
      for (int c = 0; c < 3; ++c)
        frame.plane(s, kEmissionOffset + c)[p] = drawn && emits ? random.uniform(0.0F, 20.0F) : 0;
      if (drawn && p % 7 == 2)  // a lamp, of which nothing but its emission is seen
        for (int c = 0; c < 3; ++c)
          frame.plane(s, c)[p] = frame.plane(s, kEmissionOffset + c)[p] = 500 + float(p % 300);
      if (drawn && escaped) frame.plane(s, kDepthOffset)[p] = kEscapedDepth;
    }
  return frame;
}

std::vector<Image> pictures_of(Execution& execution, const PictureExtent& picture, uint32_t first,
                               uint32_t last, FrameState& state) {
  std::vector<Image> pictures;
  for (uint32_t f = first; f < last; ++f) {
    std::vector<Image> made = execution.run(
        emitting_frame(int(picture.width), int(picture.height), int(picture.samples), f), {}, state);
    pictures.push_back(made[0]);
    state.assign(made.begin() + 1, made.end());
  }
  return pictures;
}

void expect_close(const Image& found, const Image& expected, float tolerance, const std::string& where) {
  ASSERT_EQ(found.pixels.size(), expected.pixels.size()) << where;
  float largest = 0, most = 0;
  for (size_t i = 0; i < found.pixels.size(); ++i) {
    largest = std::max(largest, std::fabs(expected.pixels[i]));
    most = std::max(most, std::fabs(found.pixels[i] - expected.pixels[i]));
  }
  if (expected.width > 1) {
    EXPECT_GT(largest, 0) << where;
  }
  EXPECT_LE(most, tolerance * largest) << where;
}

TEST(RecurrentParity, TheGraphGivesThePicturesAndTheStateOfTheNetwork) {
  const torch::NoGradGuard no_graph;
  for (const NetworkConfig& config : recurrent_configs())
    for (const auto& [width, height, spp] :
         {std::tuple(1, 1, 1), std::tuple(7, 5, 3), std::tuple(33, 70, 2), std::tuple(131, 37, 1)}) {
      const auto network = small_network(config, torch::kFloat32);
      const graph::Graph graph = network_graph(config);
      const NamedWeights weights = weights_of(*network);
      const PictureExtent extent = {spp, height, width};
      Execution execution(graph, weights, extent, {2});
      NetworkState expected_state;
      FrameState state;
      for (uint32_t f = 0; f < kRecurrentFrames; ++f) {
        const std::string where =
            full_title(config) + " frame " + std::to_string(f) + " " + std::to_string(width);
        const Image expected = to_image(
            network
                ->forward(make_network_input({emitting_frame(width, height, spp, f)}, config.features),
                          expected_state)
                .squeeze(0));
        const Image found = pictures_of(execution, extent, f, f + 1, state)[0];
        expect_close(found, expected, 1e-5F, where);
        ASSERT_EQ(state.size(), config.recurrence ? config.unet.encoder.size() + 1 : 0U);
        for (size_t level = 0; level < state.size(); ++level)
          expect_close(state[level], to_image(expected_state.at("h" + std::to_string(level)).squeeze(0)),
                       1e-5F, where + " state " + std::to_string(level));
      }
    }
}

TEST(RecurrentParity, AtThePublishedWidths) {
  const torch::NoGradGuard no_graph;
  NetworkConfig config = small_recurrent_config();
  config.unet.encoder = {{32, 32}, {43}, {57}, {76}, {101}};
  config.unet.bottleneck = {101};
  config.unet.decoder = {{76, 76}, {57, 57}, {43, 43}, {32, 32}, {128, 64}};
  config.initialisation = "he";
  const auto network = small_network(config, torch::kFloat32);
  const graph::Graph graph = network_graph(config);
  const NamedWeights weights = weights_of(*network);
  const PictureExtent extent = {1, 72, 128};
  Execution execution(graph, weights, extent, {2});
  NetworkState expected_state;
  FrameState state;
  for (uint32_t f = 0; f < kRecurrentFrames; ++f)
    expect_close(pictures_of(execution, extent, f, f + 1, state)[0],
                 to_image(network
                              ->forward(make_network_input({emitting_frame(128, 72, 1, f)}, config.features),
                                        expected_state)
                              .squeeze(0)),
                 1e-5F, "frame " + std::to_string(f));
}

TEST(RecurrentParity, HalvesWithTheStatePassedOnAreTheWholeAndRowsAndThreadsChangeNoBit) {
  const NetworkConfig config = recurrent_configs().back();
  const graph::Graph graph = network_graph(config);
  const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
  const PictureExtent extent = {2, 45, 77};
  const auto run = [&](const std::vector<std::pair<uint32_t, uint32_t>>& pieces,
                       const ExecutionOptions& options) {
    std::vector<Image> pictures;
    FrameState state;
    for (const auto& [first, last] : pieces) {
      Execution execution(graph, weights, extent, options);
      for (Image& picture : pictures_of(execution, extent, first, last, state))
        pictures.push_back(std::move(picture));
    }
    for (Image& left : state) pictures.push_back(std::move(left));
    return pictures;
  };
  const std::vector<Image> whole = run({{0, kRecurrentFrames}}, {1});
  ASSERT_EQ(whole.size(), kRecurrentFrames + 6);
  for (const int64_t block : {0, 1, 16})
    for (const int threads : {1, 2}) {
      const std::vector<Image> halves = run({{0, 2}, {2, kRecurrentFrames}}, {threads, block});
      for (size_t i = 0; i < whole.size(); ++i)
        EXPECT_EQ(halves[i].pixels, whole[i].pixels) << i << " " << block;
    }
}

TEST(RecurrentParity, WhatDoesNotFitIsAnError) {
  const NetworkConfig config = small_recurrent_config();
  const graph::Graph graph = network_graph(config);
  const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
  const PictureExtent extent = {1, 6, 8};
  Execution execution(graph, weights, extent);
  FrameState state;
  pictures_of(execution, extent, 0, 1, state);
  FrameState other = state;
  other[1] = Image(8, 6, other[1].channels);
  EXPECT_ERROR(pictures_of(execution, extent, 1, 2, other), "state of a frame before");
  other = state;
  other.pop_back();
  EXPECT_ERROR(pictures_of(execution, extent, 1, 2, other), "state of a frame before");
  EXPECT_ERROR(network_graph(config, {1, false}), "cannot filter parts of it");
  EXPECT_ERROR(network_graph(config, {0, true}), "cannot filter parts of it");
}

}  // namespace
}  // namespace ld
