#include "runtime/row_schedule.h"

#include <gtest/gtest.h>

#include "models/graphs/network_graph.h"

namespace ld {
namespace {

/// Every row of every value is made once and in order, is there when it is read, and fits where it is put.
TEST(RowSchedule, RowsAreThereAsLongAsTheyAreRead) {
  NetworkConfig config;
  config.demodulation = "albedo";
  config.rejection = true;
  const graph::Graph graph = layer_graph(config);
  std::vector<size_t> producer(graph.values.size());
  for (size_t n = 0; n < graph.nodes.size(); ++n)
    for (const graph::ValueId output : graph.nodes[n].outputs) producer[output] = n;
  for (const int64_t height : {1, 2, 31, 33, 100, 257})
    for (const int64_t block : {1, 7, 32, 300}) {
      const PictureExtent picture = {2, height, 40};
      const RowSchedule schedule(graph, picture, block);
      std::vector<int64_t> made(graph.nodes.size(), 0);
      int64_t done = 0;
      schedule.walk(
          [&](size_t index, int64_t begin, int64_t end) {
            const graph::Node& node = graph.nodes[index];
            EXPECT_EQ(begin, made[index]);
            for (const graph::ValueId input : node.inputs) {
              const int64_t rows = extent_of(graph, input, picture).height;
              EXPECT_LE(graph::rows_read_to(node.op, end, rows), made[producer[input]]) << graph[input].name;
              EXPECT_GE(graph::rows_read_from(node.op, begin, rows),
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

TEST(RowSchedule, AValueThatNobodyReadsTwiceNeedsABlock) {
  NetworkConfig config;
  const graph::Graph graph = layer_graph(config);
  const RowSchedule schedule(graph, {8, 1080, 1920}, 32);
  for (graph::ValueId id = 0; id < graph.values.size(); ++id)
    if (graph[id].name == "features") {
      EXPECT_EQ(schedule.capacity(id), 32);
    }
}

}  // namespace
}  // namespace ld
