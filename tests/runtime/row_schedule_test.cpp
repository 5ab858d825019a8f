#include "runtime/row_schedule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "models/check_network.h"
#include "models/graphs/network_graph.h"

namespace ld {
namespace {

/// Every row of every value is made once and in order, is there when it is read, and fits where it is put.
void expect_rows_to_be_there(const graph::Graph& graph) {
  for (const int64_t height : {1, 2, 31, 33, 100, 257})
    for (const int64_t block : {1, 7, 32, 300}) {
      const PictureExtent picture = {2, height, 40};
      const RowSchedule schedule(graph, picture, block);
      const std::vector<Unit>& units = schedule.units();
      std::vector<size_t> producer(graph.values.size());
      for (size_t u = 0; u < units.size(); ++u)
        for (const size_t n : units[u].nodes)
          for (const graph::ValueId output : graph.nodes[n].outputs) producer[output] = u;
      std::vector<int64_t> made(units.size(), 0);
      int64_t done = 0;
      schedule.walk(
          [&](size_t index, int64_t begin, int64_t end) {
            EXPECT_EQ(begin, made[index]);
            for (const size_t n : units[index].nodes)
              for (const graph::ValueId input : graph.nodes[n].inputs) {
                if (producer[input] == index) continue;
                const graph::Operator& op = graph.nodes[n].op;
                const int64_t rows = graph::extent_of(graph, input, picture).height;
                EXPECT_LE(graph::rows_read_to(op, end, rows), made[producer[input]]) << graph[input].name;
                EXPECT_GE(graph::rows_read_from(op, begin, rows),
                          made[producer[input]] - schedule.capacity(input))
                    << graph[input].name << " of height " << height << " in blocks of " << block;
              }
            made[index] = end;
          },
          [&](int64_t begin, int64_t end) {
            EXPECT_EQ(begin, done);
            done = end;
          });
      EXPECT_EQ(done, height);
    }
}

/// The names of the values that no row is made of.
std::set<std::string> names_in_tiles(const graph::Graph& graph) {
  const RowSchedule schedule(graph, {8, 100, 40}, 32);
  std::set<std::string> names;
  for (graph::ValueId id = 0; id < graph.values.size(); ++id)
    if (schedule.capacity(id) == 0) names.insert(graph[id].name);
  return names;
}

TEST(Units, WhatPixelwiseNodesLeaveToOneAnotherIsNoRow) {
  NetworkConfig config;
  config.demodulation = "albedo";
  config.rejection = true;
  EXPECT_EQ(names_in_tiles(network_graph(config)),
            (std::set<std::string>{"features", "radiance", "sample_partitioner", "log_n", "opacity",
                                   "composited"}));
  config.name = "pixel_splat";
  EXPECT_EQ(names_in_tiles(network_graph(config)),
            (std::set<std::string>{"features", "radiance", "valid", "demodulated", "statistics", "drawn"}));
}

TEST(RowSchedule, RowsAreThereAsLongAsTheyAreRead) {
  for (const std::string& name : network_names())
    for (const char* upsampling : {"bilinear", "nearest"}) {
      SCOPED_TRACE(name);
      NetworkConfig config;
      config.name = name;
      if (network_traits(name).filter != Filter::none) config.demodulation = "albedo";
      config.rejection = network_traits(name).filter == Filter::splat;
      config.unet.upsampling = upsampling;
      if (network_traits(name).has_levels) config.levels = 5;
      expect_rows_to_be_there(network_graph(config));
    }
}

/// The rows that operators read at most, said row by row.
void expect_reach(const graph::Operator& op, int64_t height, int64_t rows,
                  const std::function<std::pair<int64_t, int64_t>(int64_t)>& first_and_last) {
  for (int64_t y = 0; y < rows; ++y) {
    const auto [first, last] = first_and_last(y);
    EXPECT_EQ(graph::rows_read_to(op, y + 1, height), std::clamp<int64_t>(last + 1, 0, height)) << y;
    EXPECT_EQ(graph::rows_read_from(op, y, height), std::clamp<int64_t>(first, 0, height)) << y;
  }
}

TEST(Reach, IsWhatTheOperatorsOfSeveralResolutionsRead) {
  for (const int levels : {1, 2, 3, 6}) {
    const double n = std::exp2(levels);
    expect_reach(graph::Upsample{false, levels}, 5, int64_t(5 * n) - 1, [&](int64_t y) {
      const auto row = int64_t(std::floor(double(y) / n));
      return std::pair(row, row);
    });
    expect_reach(graph::Upsample{true, levels}, 5, int64_t(5 * n) - 1, [&](int64_t y) {
      const auto row = int64_t(std::floor((double(y) + 0.5) / n - 0.5));
      return std::pair(row, row + 1);
    });
  }
  for (const graph::Operator& op :
       {graph::Operator(graph::SpaceToDepth{}), graph::Operator(graph::HalveLight{})})
    expect_reach(op, 9, 5, [](int64_t y) { return std::pair(2 * y, 2 * y + 1); });
  expect_reach(graph::DepthToSpace{}, 5, 9, [](int64_t y) { return std::pair(y / 2, y / 2); });
  expect_reach(graph::EdgeConvolution{"", 5}, 9, 9, [](int64_t y) { return std::pair(y - 2, y + 2); });
  expect_reach(graph::GatherTaps{3}, 9, 9, [](int64_t y) { return std::pair(y - 1, y + 1); });
  expect_reach(graph::Halve{}, 9, 5, [](int64_t y) { return std::pair(2 * y, 2 * y + 1); });
  expect_reach(graph::Received{5}, 9, 9, [](int64_t y) { return std::pair(y - 2, y + 2); });
  expect_reach(graph::Blur{7}, 9, 9, [](int64_t y) { return std::pair(y - 3, y + 3); });
  expect_reach(graph::BlendLevels{}, 9, 9, [](int64_t y) { return std::pair(y, y); });
}

TEST(RowSchedule, AValueThatNobodyReadsTwiceNeedsABlock) {
  NetworkConfig config;
  const graph::Graph graph = network_graph(config);
  const RowSchedule schedule(graph, {8, 1080, 1920}, 32);
  for (graph::ValueId id = 0; id < graph.values.size(); ++id)
    if (graph[id].name == "composited") {
      EXPECT_EQ(schedule.capacity(id), 32);
    }
}

}  // namespace
}  // namespace ld
