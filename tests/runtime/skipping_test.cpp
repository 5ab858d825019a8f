// Work that is left out: what changes, and by how much.
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <limits>

#include "graph/light_reach.h"
#include "runtime/demand.h"
#include "tests/runtime/graph_cases.h"
#include "tests/runtime/run_graph.h"
#include "tests/support/expect_error.h"

namespace ld {
namespace {

NamedWeights small_weights(const NetworkConfig& config) {
  return weights_of(*small_network(config, torch::kFloat32));
}

ExecutionOptions skipping(std::optional<double> within, int threads = 1, int64_t rows = 0) {
  ExecutionOptions options;
  options.threads = threads;
  options.block_rows = rows;
  options.skip_within = within;
  return options;
}

/// Light and surfaces of a pixel's sample.
using Paint = std::function<void(int x, int y, int s, float* radiance, float& albedo)>;

Frame painted(int width, int height, int spp, const Paint& paint) {
  Frame frame = random_frame(width, height, spp, 5);
  for (int s = 0; s < spp; ++s)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        std::array<float, 3> radiance = {};
        float albedo = 0;
        paint(x, y, s, radiance.data(), albedo);
        const size_t p = size_t(y) * size_t(width) + size_t(x);
        for (int c = 0; c < 3; ++c) {
          frame.plane(s, c)[p] = radiance[size_t(c)];
          frame.plane(s, find_feature("albedo").offset + c)[p] = albedo;
          frame.plane(s, find_feature("specular").offset + c)[p] = 0;
        }
      }
  sanitise(frame);
  return frame;
}

void set_all(float* radiance, float value) {
  std::fill_n(radiance, 3, value);
}

struct LightCase {
  const char* name;
  Frame frame;
};

float grain(int x, int y, int s) {
  return float((x * 7919 + y * 104729 + s * 1299709) % 1000) / 1000;
}

/// Even light of all kinds, and what ends it.
std::vector<LightCase> light_cases() {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  std::vector<LightCase> made;
  const auto add = [&](const char* name, int width, int height, int spp, const Paint& paint) {
    made.push_back({name, painted(width, height, spp, paint)});
  };
  add("constant", 67, 45, 3, [](int, int, int, float* r, float&) { set_all(r, 0.7F); });
  add("black", 67, 45, 3, [](int, int, int, float* r, float& a) {
    set_all(r, 0);
    a = 0.5F;
  });
  add("half", 83, 61, 2, [](int x, int y, int s, float* r, float& a) {
    set_all(r, x < 48 ? 3.0F : grain(x, y, s));
    a = x < 48 ? 0.0F : 0.3F;
  });
  add("black half", 83, 61, 2,
      [](int x, int y, int s, float* r, float&) { set_all(r, y < 40 ? 0.0F : grain(x, y, s)); });
  for (const int reach : {0, 1, 2, 3})  // of a kernel of 5 it is 2
    add("firefly", 64, 33, 2, [=](int x, int y, int s, float* r, float&) {
      set_all(r, x == 31 + reach && y == 16 && s == 1 ? 6e4F : 1.5F);
    });
  add("gradient", 90, 30, 2, [](int x, int, int, float* r, float&) { set_all(r, 1 + 1e-6F * float(x)); });
  add("steep gradient", 90, 30, 2,
      [](int x, int y, int, float* r, float&) { set_all(r, 1e-3F * float(x * y)); });
  add("albedo", 64, 40, 2, [](int x, int, int, float* r, float& a) {
    set_all(r, 1);
    a = x < 32 ? 0.0F : 0.25F * float(x % 4);
  });
  add("holes", 64, 40, 2, [](int x, int y, int s, float* r, float&) {
    set_all(r, x % 9 == 0 && y > 20 && (s == 0 || y > 30) ? kNaN : 0.25F);
  });
  add("infinite", 64, 40, 1, [](int x, int, int, float* r, float&) {
    set_all(r, x == 40 ? std::numeric_limits<float>::infinity() : 2.0F);
  });
  add("large", 40, 20, 2, [](int x, int, int, float* r, float&) { set_all(r, x < 20 ? 3e38F : 65504.0F); });
  add("denormal", 40, 20, 2, [](int x, int, int, float* r, float&) { set_all(r, x < 20 ? 1e-38F : 1e-42F); });
  add("one pixel", 1, 1, 1, [](int, int, int, float* r, float&) { set_all(r, 0.5F); });
  add("one row", 50, 1, 1, [](int, int, int, float* r, float&) { set_all(r, 0.5F); });
  made.push_back({"uneven", uneven_frame(43, 27, 3)});
  return made;
}

/// |a - b| / (1 + |b|), the largest.
double farthest_apart(const Image& a, const Image& b) {
  double largest = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i)
    largest = std::max(
        largest, std::fabs(double(a.pixels[i]) - double(b.pixels[i])) / (1 + std::fabs(double(b.pixels[i]))));
  return largest;
}

TEST(Skipping, StaysWithinTheBoundAndAtZeroChangesNoBit) {
  const std::vector<LightCase> all = light_cases();
  for (const NetworkConfig& config : every_network()) {
    const NamedWeights weights = small_weights(config);
    for (const LightCase& one : all) {
      const Image all_work = in_runtime(config, weights, one.frame);
      EXPECT_EQ(in_runtime(config, weights, one.frame, skipping(0)).pixels, all_work.pixels)
          << full_title(config) << ", " << one.name;
      for (const double within : {1e-6, 1e-4, 1e-2})
        EXPECT_LE(farthest_apart(in_runtime(config, weights, one.frame, skipping(within)), all_work), within)
            << full_title(config) << ", " << one.name << ", " << within;
    }
  }
}

TEST(Skipping, DependsOnNeitherThreadsNorRowsAtATime) {
  const std::vector<LightCase> all = light_cases();
  for (const NetworkConfig& config : every_config()) {
    const NamedWeights weights = small_weights(config);
    for (const LightCase& one : all) {
      const Image expected = in_runtime(config, weights, one.frame, skipping(1e-4));
      for (const auto& [threads, rows] : {std::pair<int, int64_t>{2, 0}, {3, 1}, {2, 7}, {1, 64}})
        EXPECT_EQ(in_runtime(config, weights, one.frame, skipping(1e-4, threads, rows)).pixels,
                  expected.pixels)
            << full_title(config) << ", " << one.name << ", " << threads << " threads, " << rows << " rows";
    }
  }
}

NetworkConfig layer_config() {
  NetworkConfig config = small_config();
  config.name = "layer";
  return config;
}

Skipped skipped_in(const NetworkConfig& config, const Frame& frame, std::optional<double> within) {
  const graph::Graph graph = network_graph(config);
  const NamedWeights weights = small_weights(config);
  Execution execution(graph, weights, {frame.spp, frame.height, frame.width}, skipping(within));
  execution.run(frame);
  return execution.skipped();
}

TEST(Skipping, IsReported) {
  const NetworkConfig config = layer_config();
  const Frame frame = painted(
      160, 48, 4, [](int x, int y, int s, float* r, float&) { set_all(r, x < 80 ? 2.0F : grain(x, y, s)); });
  EXPECT_EQ(skipped_in(config, frame, std::nullopt).pixels, 0);
  EXPECT_EQ(skipped_in(config, frame, 0).pixels, 0) << "equal light is not black";
  // Whole blocks of 8, up to a block that a kernel reaches into the noise.
  EXPECT_DOUBLE_EQ(skipped_in(config, frame, 1e-4).pixels, 72.0 / 160);
}

TEST(Skipping, MakesEqualSamplesOnce) {
  const NetworkConfig config = layer_config();
  Frame frame = random_frame(96, 20, 4, 3);
  for (int s = 1; s < 4; ++s)
    std::copy_n(frame.plane(0, 0), size_t(frame.channels) * frame.plane_size(), frame.plane(s, 0));
  sanitise(frame);
  const Skipped skipped = skipped_in(config, frame, 0);
  EXPECT_GE(skipped.samples, 0.5);
  EXPECT_LE(skipped.samples, 0.75);
  EXPECT_EQ(skipped_in(config, random_frame(96, 20, 4, 3), 0).samples, 0);
  const NamedWeights weights = small_weights(config);
  EXPECT_EQ(in_runtime(config, weights, frame, skipping(0)).pixels,
            in_runtime(config, weights, frame).pixels);
}

/// Weights with which the first layer takes every sample (sign 1) or none (-1), in a part of the picture.
NamedWeights one_sided(const NetworkConfig& config, float sign) {
  NamedWeights weights = small_weights(config);
  const size_t last = config.sample_partitioner.size();
  const std::string name = "sample_partitioner." + std::to_string(last) + ".bias";
  NamedWeight bias = weights.at(name);
  bias.values[0] += sign * 500;
  weights.add(name, std::move(bias));
  return weights;
}

TEST(Skipping, LeavesOutLayersWithoutInfluence) {
  for (const NetworkConfig& config : graph_configs()) {
    if (!has_layers(config) || config.compositing != "alpha") continue;
    const graph::Graph graph = network_graph(config);
    const Frame frame = random_frame(70, 90, 2, 3);
    for (const float sign : {1.0F, -1.0F}) {
      const NamedWeights weights = one_sided(config, sign);
      Execution execution(graph, weights, {2, 90, 70}, skipping(0, 2));
      const Image picture = execution.run(frame)[0];
      EXPECT_EQ(picture.pixels, in_runtime(config, weights, frame).pixels) << full_title(config);
      // Of three layers, the weights of the second and third do not add up to 1 in every pixel, but to a bit
      // less.
      if (config.name == "layer" && (sign > 0 || config.layers == 2)) {
        EXPECT_GT(execution.skipped().layers, 0.2) << full_title(config);
      }
    }
  }
}

TEST(Skipping, LightReachOfNetworks) {
  for (const NetworkConfig& config : every_config()) {
    const std::optional<graph::LightReach> reach = graph::light_reach(network_graph(config));
    const bool mean =
        config.name == "layer" || config.name == "sample_splat" ||
        (works_on_pixels(config) && averages(config.name) && !network_traits(config.name).has_levels);
    ASSERT_EQ(reach.has_value(), mean) << full_title(config);
    if (mean) {
      EXPECT_EQ(reach->radius, config.kernel_size / 2) << full_title(config);
    }
  }
}

/// What is not wanted may hold anything: the picture where it is wanted has its bits.
TEST(Skipping, WhatIsWantedIsMade) {
  for (const NetworkConfig& config : graph_configs()) {
    const graph::Graph graph = network_graph(config);
    if (!graph.state.empty()) continue;
    Demand demand(graph, {2, 40, 60});
    std::vector<Span> rows(40);
    rows[20] = {30, 31};
    demand.want(rows);
    EXPECT_FALSE(demand.row(graph.output, 19).meets(0, 60));
    EXPECT_TRUE(demand.wants(graph.output, 20, 24, 8));
    // Every sample in the kernel's reach, at least.
    const graph::ValueId samples = graph.nodes[0].outputs[0];
    const auto radius = config.name == "recurrent" ? 0 : 1;
    for (int64_t y = 20 - radius; y <= 20 + radius; ++y)
      for (int64_t x = 30 - radius; x <= 30 + radius; ++x)
        EXPECT_TRUE(demand.wants(samples, y, x, 1)) << full_title(config);
  }
}

}  // namespace
}  // namespace ld
