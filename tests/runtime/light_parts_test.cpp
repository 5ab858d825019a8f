// Parts of the light, filtered with the weights of the picture, add up to it.
#include <gtest/gtest.h>

#include <limits>

#include "tests/runtime/graph_cases.h"
#include "tests/runtime/run_graph.h"
#include "tests/support/expect_error.h"

namespace ld {
namespace {

/// Of networks that filter, so that parts go the way of the whole.
std::vector<NetworkConfig> graphs_of_parts() {
  std::vector<NetworkConfig> configs;
  for (NetworkConfig& config : graph_configs())
    if (averages(config.name)) configs.push_back(std::move(config));
  return configs;
}

/// Splits the radiance of a frame in three parts, by shares of every channel that add up to 1 and of which
/// one may be negative, and gives it an alpha.
void split_light(Frame& frame) {
  RandomStream random(9, RandomPurpose::test);
  for (const char* name : {"a", "b", "rest"}) frame.add_part(name);
  frame.alpha.resize(frame.valid.size());
  for (int s = 0; s < frame.spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p) {
      for (int c = 0; c < 3; ++c) {
        const double light = frame.plane(s, c)[p];
        const auto a = float(light * random.uniform(0.0F, 1.0F)),
                   b = float(light * random.uniform(0.0F, 1.0F));
        frame.part_plane(0, s, c)[p] = a;
        frame.part_plane(1, s, c)[p] = b;
        frame.part_plane(2, s, c)[p] = float(light - double(a) - double(b));
      }
      if (frame.valid_plane(s)[p] != 0)
        frame.alpha[size_t(s) * frame.plane_size() + p] = random.uniform(0.0F, 1.0F);
    }
}

/// The picture, its parts and alpha, [3 + 3 parts + 1, H, W].
Image with_parts(const NetworkConfig& config, const NamedWeights& weights, const Frame& frame,
                 const ExecutionOptions& options = {}) {
  const graph::Graph graph = network_graph(config, {int64_t(frame.parts.size()), !frame.alpha.empty()});
  return Execution(graph, weights, {frame.spp, frame.height, frame.width}, options).run(frame)[0];
}

std::vector<float> planes_of(const Image& image, int first, int count) {
  return {image.plane(first), image.plane(first) + size_t(count) * image.plane_size()};
}

/// The largest difference between the picture and the sum of the parts, over the largest of their values.
double relative_error_of_sum(const Image& all, int parts) {
  double most = 0, largest = 0;
  for (int c = 0; c < 3; ++c)
    for (size_t p = 0; p < all.plane_size(); ++p) {
      double sum = 0;
      for (int part = 1; part <= parts; ++part) {
        sum += double(all.plane(3 * part + c)[p]);
        largest = std::max(largest, std::fabs(double(all.plane(3 * part + c)[p])));
      }
      most = std::max(most, std::fabs(sum - double(all.plane(c)[p])));
      largest = std::max(largest, double(all.plane(c)[p]));
    }
  return most == 0 ? 0 : most / largest;
}

bool all_finite(const Image& image) {
  return std::all_of(image.pixels.begin(), image.pixels.end(), [](float v) { return std::isfinite(v); });
}

TEST(LightParts, SumToThePictureWhoseBitsTheyLeave) {
  double worst = 0;
  for (const NetworkConfig& config : graphs_of_parts()) {
    const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
    for (const auto& [width, height, spp] :
         {std::tuple(1, 1, 1), std::tuple(1, 1, 64), std::tuple(7, 5, 3), std::tuple(33, 70, 2),
          std::tuple(131, 37, 1), std::tuple(16, 16, 64)}) {
      Frame frame = uneven_frame(width, height, spp);
      const Image expected = in_runtime(config, weights, frame);
      split_light(frame);
      const Image all = with_parts(config, weights, frame);
      ASSERT_EQ(all.channels, 13);
      EXPECT_EQ(planes_of(all, 0, 3), expected.pixels) << full_title(config);
      const double error = relative_error_of_sum(all, 3);
      EXPECT_LE(error, 1e-5) << full_title(config) << ", " << width << " x " << height << " at " << spp;
      worst = std::max(worst, error);
    }
  }
  RecordProperty("worst", std::to_string(worst));
  std::printf("largest error of a sum: %.2g of the largest value\n", worst);
}

TEST(LightParts, NothingAllAndConstantsComeOutAsThat) {
  for (const NetworkConfig& config : graphs_of_parts()) {
    const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
    Frame frame = uneven_frame(45, 39, 3);
    frame.add_part("nothing");
    frame.add_part("all");
    frame.alpha.assign(frame.valid.begin(), frame.valid.end());
    for (int s = 0; s < frame.spp; ++s)
      std::copy_n(frame.plane(s, 0), 3 * frame.plane_size(), frame.part_plane(1, s, 0));
    const Image all = with_parts(config, weights, frame);
    const float largest = *std::max_element(all.pixels.begin(), all.pixels.end());
    for (size_t p = 0; p < all.plane_size(); ++p) {
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(all.plane(3 + c)[p], 0) << full_title(config);
        ASSERT_NEAR(all.plane(6 + c)[p], all.plane(c)[p], 1e-6F * largest) << full_title(config);
      }
      const float alpha = all.plane(9)[p];
      ASSERT_TRUE(alpha == 0 || std::fabs(alpha - 1) < 1e-5F) << full_title(config) << ": " << alpha;
      if (alpha == 0) {
        ASSERT_EQ(all.plane(0)[p], 0) << full_title(config);
      }
    }
  }
}

TEST(LightParts, WhateverTheUnitsOfTheLight) {
  for (const NetworkConfig& config : graphs_of_parts())
    for (const float factor : {1e-38F, 1e-30F, 1e30F, 1e35F, 1e36F}) {
      const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
      Frame frame = uneven_frame(23, 17, 2);
      for (int s = 0; s < frame.spp; ++s)
        for (size_t i = 0; i < 3 * frame.plane_size(); ++i) frame.plane(s, 0)[i] *= factor;
      split_light(frame);
      const Image all = with_parts(config, weights, frame);
      EXPECT_TRUE(all_finite(all)) << full_title(config);
      if (factor < 1e-37F) continue;  // denormals are flushed
      EXPECT_LE(relative_error_of_sum(all, 3), 1e-5) << full_title(config) << ", times " << factor;
    }
}

// Parts that cancel are far larger than what they sum to, in single samples or everywhere.
TEST(LightParts, StayFiniteWhateverTheyAre) {
  for (const NetworkConfig& config : graphs_of_parts()) {
    const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
    Frame frame = uneven_frame(23, 17, 2);
    const Image expected = in_runtime(config, weights, frame);
    for (const char* name : {"up", "down", "wild"}) frame.add_part(name);
    RandomStream random(3, RandomPurpose::test);
    const float wild[] = {0,
                          -0.0F,
                          1e-45F,
                          -1e-38F,
                          65504,
                          3e38F,
                          -3e38F,
                          std::numeric_limits<float>::max(),
                          -65504,
                          1e35F,
                          std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::quiet_NaN()};
    for (int s = 0; s < frame.spp; ++s)
      for (int c = 0; c < 3; ++c)
        for (size_t p = 0; p < frame.plane_size(); ++p) {
          frame.part_plane(0, s, c)[p] = 3e38F;
          frame.part_plane(1, s, c)[p] = -3e38F;
          frame.part_plane(2, s, c)[p] = wild[size_t(random.uniform(0.0F, 11.99F))];
        }
    EXPECT_GT(sanitise(frame).parts, 0);
    const Image all = with_parts(config, weights, frame);
    EXPECT_TRUE(all_finite(all)) << full_title(config);
    EXPECT_EQ(planes_of(all, 0, 3), expected.pixels) << full_title(config);
    for (size_t p = 0; p < 3 * all.plane_size(); ++p)
      ASSERT_EQ(all.plane(3)[p], -all.plane(6)[p]) << full_title(config);
  }
}

TEST(LightParts, RowsAtATimeAndThreadsChangeNoBit) {
  for (const NetworkConfig& config : averaging_configs()) {
    const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
    Frame frame = uneven_frame(301, 40, 1);
    split_light(frame);
    const Image expected = with_parts(config, weights, frame);
    for (const int64_t block : {1, 16, 1000})
      for (const int threads : {1, 2})
        EXPECT_EQ(with_parts(config, weights, frame, {threads, block}).pixels, expected.pixels)
            << full_title(config) << ", " << block << " rows, " << threads << " threads";
  }
}

TEST(LightParts, OfANetworkThatPredictsColoursAreRefused) {
  NetworkConfig config = small_config();
  config.name = "espcn_kpcn";
  EXPECT_ERROR(network_graph(config, {1, false}), "predicts colours");
  EXPECT_ERROR(network_graph(config, {0, true}), "predicts colours");
}

TEST(LightParts, OfAFrameThatHasFewerAreAnError) {
  const NetworkConfig config = averaging_configs()[0];
  const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
  const Frame frame = random_frame(5, 4, 2);
  const graph::Graph one = network_graph(config, {1, false}), alpha = network_graph(config, {0, true});
  EXPECT_ERROR(Execution(one, weights, {2, 4, 5}).run(frame), "0 light parts without alpha; expected 1");
  EXPECT_ERROR(Execution(alpha, weights, {2, 4, 5}).run(frame), "expected 0 and alpha");
}

}  // namespace
}  // namespace ld
