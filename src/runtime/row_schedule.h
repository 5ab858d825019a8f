// The order in which the rows of a graph's values are made, and how many of each must exist at a time.
#pragma once

#include <functional>
#include <vector>

#include "graph/extent.h"
#include "runtime/unit.h"

namespace ld {

using graph::PictureExtent;
using graph::ValueExtent;

/// Every row of every value is made once, when something is to read it, and forgotten when nothing will any
/// more. So no result depends on how many rows are made at a time. A unit that reads what one other puts out,
/// and leaves less than that, runs at once, so that the larger rows need not wait.
class RowSchedule {
 public:
  /// About `block` rows of full resolution are made at a time.
  RowSchedule(const graph::Graph& graph, const PictureExtent& picture, int64_t block);

  const std::vector<Unit>& units() const { return units_; }

  /// Rows of a value that exist at a time; 0 of those that no row is made of (runtime/unit.h).
  int64_t capacity(graph::ValueId id) const { return capacity_[id]; }

  /// run(unit, begin, end) makes those rows of what the unit puts out. Calls done(begin, end) whenever rows
  /// of all outputs of the graph are there. Of the graph's state all rows are made, in their time.
  using Run = std::function<void(size_t unit, int64_t begin, int64_t end)>;
  using Done = std::function<void(int64_t begin, int64_t end)>;
  void walk(const Run& run, const Done& done) const;

 private:
  struct Walk;
  std::vector<size_t> eager_readers(size_t unit) const;

  const graph::Graph& graph_;
  int64_t block_;
  std::vector<graph::ValueId> outputs_;
  std::vector<ValueExtent> extents_;
  std::vector<Unit> units_;
  std::vector<size_t> producer_;                // unit of each value
  std::vector<std::vector<size_t>> consumers_;  // units of each value
  std::vector<std::vector<size_t>> eager_;      // units that run right after each
  std::vector<int64_t> capacity_;
};

}  // namespace ld
