// Which pixels of a graph's values somebody will read.
#pragma once

#include <algorithm>
#include <vector>

#include "graph/extent.h"
#include "graph/graph.h"

namespace ld {

using graph::Span;

/// A stretch of each row of each value. What lies outside need not be made: it may hold anything.
class Demand {
 public:
  /// All pixels of all values.
  Demand(const graph::Graph& graph, const graph::PictureExtent& picture);
  void want_all();

  /// Of the output, row by row, and of all other values what the graph makes those pixels from. The graph has
  /// no other outputs and no state.
  void want(const std::vector<Span>& rows_of_output);

  const std::vector<Span>& rows(graph::ValueId id) const { return rows_[id]; }
  const Span& row(graph::ValueId id, int64_t y) const { return rows_[id][size_t(y)]; }
  bool wants(graph::ValueId id, int64_t y, int64_t x, int64_t count) const {
    return row(id, y).meets(x, count);
  }
  /// Any output of a node.
  bool wants(const graph::Node& node, int64_t y, int64_t x, int64_t count) const {
    return std::any_of(node.outputs.begin(), node.outputs.end(),
                       [&](graph::ValueId id) { return wants(id, y, x, count); });
  }

  int64_t bytes() const;

 private:
  const graph::Graph& graph_;
  std::vector<int64_t> widths_;          // of each value
  std::vector<std::vector<Span>> rows_;  // of each value
};

}  // namespace ld
