// Sizes of a graph's values and what its nodes compute, once a frame's size is known.
#pragma once

#include "graph/graph.h"

namespace ld::graph {

/// Of a frame.
struct PictureExtent {
  int64_t samples = 0, height = 0, width = 0;
  bool operator==(const PictureExtent& other) const {
    return samples == other.samples && height == other.height && width == other.width;
  }
};

/// Height, width and planes of a value for such a frame.
struct ValueExtent {
  int64_t planes, height, width;
};
ValueExtent extent_of(const Graph& graph, ValueId id, const PictureExtent& picture);

/// A weight or a bias.
struct Parameter {
  std::string name;
  std::vector<int64_t> shape;
};

/// All that the graph's operators read, each once.
std::vector<Parameter> parameters(const Graph& graph);
std::vector<Parameter> parameters(const Graph& graph, const Node& node);

/// How many numbers a parameter, or all parameters of a graph, are.
int64_t count_of(const Parameter& parameter);
int64_t parameter_count(const Graph& graph);

/// What a node multiplies and adds for one frame: with its weights, and with the taps of its kernels
/// (models/graphs/network_cost.h has the rules).
struct NodeCost {
  double weights = 0, taps = 0;
};
NodeCost cost_of(const Graph& graph, const Node& node, const PictureExtent& picture);

}  // namespace ld::graph
