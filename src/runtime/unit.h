// Nodes of a graph that run together.
#pragma once

#include <vector>

#include "graph/graph.h"

namespace ld {

/// One node, or several pixelwise ones (graph/operators.h) of one resolution, which run one after the other
/// on each tile of pixels: what they leave to one another alone stays in the cache and never becomes a row.
struct Unit {
  std::vector<size_t> nodes;            // in the graph's order
  std::vector<graph::ValueId> inputs;   // that other units put out
  std::vector<graph::ValueId> outputs;  // that other units read or the graph puts out

  /// How far it reads: all pixelwise ones alike.
  const graph::Operator& reach(const graph::Graph& graph) const { return graph.nodes[nodes[0]].op; }
};

/// Every node in one unit. No unit reads, through others, what it puts out.
std::vector<Unit> units_of(const graph::Graph& graph);

}  // namespace ld
