#include "graph/extent.h"

#include <set>

namespace ld::graph {
namespace {

/// The parameters of each operator; of those that are not named here, none.
struct ParametersOf {
  const Graph& graph;
  const Node& node;

  int64_t channels(size_t input) const { return graph[node.inputs[input]].channels; }

  std::vector<Parameter> layers(const FullyConnected& op, int64_t inputs) const {
    std::vector<Parameter> list;
    for (size_t i = 0; i < op.widths.size(); ++i) {
      const std::string name = op.weights + "." + std::to_string(i);
      list.push_back({name + ".weight", {op.widths[i], inputs}});
      list.push_back({name + ".bias", {op.widths[i]}});
      inputs = op.widths[i];
    }
    return list;
  }

  template <class Op>
  std::vector<Parameter> operator()(const Op&) const {
    return {};
  }
  std::vector<Parameter> operator()(const FullyConnected& op) const {
    return layers(op, channels(0) + (node.inputs.size() > 1 ? channels(1) : 0));
  }
  std::vector<Parameter> convolution(const std::string& weights, int64_t kernel) const {
    int64_t inputs = 0;
    for (size_t i = 0; i < node.inputs.size(); ++i) inputs += channels(i);
    const int64_t outputs = graph[node.outputs[0]].channels;
    return {{weights + ".weight", {outputs, inputs, kernel, kernel}}, {weights + ".bias", {outputs}}};
  }
  std::vector<Parameter> operator()(const Convolution& op) const { return convolution(op.weights, 3); }
  std::vector<Parameter> operator()(const EdgeConvolution& op) const {
    return convolution(op.weights, op.kernel);
  }
  std::vector<Parameter> operator()(const Reject& op) const {
    return layers({op.weights, {1}}, channels(1) + channels(2));
  }
  std::vector<Parameter> operator()(const Splat& op) const {
    return layers(op.generator, channels(0) + channels(1));
  }
  std::vector<Parameter> operator()(const Gather& op) const {
    return layers(op.generator, channels(0) + channels(1));
  }
  std::vector<Parameter> operator()(const ModulationFactors& op) const {
    return layers({op.weights, {1}}, 1 + channels(1));
  }
};

/// What one item of a node multiplies and adds at one pixel.
struct CostOf {
  const Graph& graph;
  const Node& node;

  int64_t channels(size_t input) const { return graph[node.inputs[input]].channels; }

  /// Of the last layer's outputs, so many are made.
  double layers(const FullyConnected& op, int64_t inputs, int64_t outputs) const {
    double sum = 0;
    for (size_t i = 0; i < op.widths.size(); ++i) {
      const int64_t width = i + 1 < op.widths.size() ? op.widths[i] : outputs;
      sum += double(width * inputs);
      inputs = width;
    }
    return sum;
  }
  /// The values from that input on, and the sum of the weights.
  double taps(int64_t kernel, size_t first_value) const {
    int64_t filtered = 1;
    for (size_t i = first_value; i < node.inputs.size(); ++i) filtered += channels(i);
    return double(kernel * kernel * filtered);
  }

  template <class Op>
  NodeCost operator()(const Op&) const {
    NodeCost cost;
    for (const Parameter& parameter : parameters(graph, node))
      if (parameter.shape.size() > 1) cost.weights += double(count_of(parameter));
    return cost;
  }
  NodeCost operator()(const FullyConnected& op) const {
    const int64_t inputs = channels(0) + (node.inputs.size() > 1 ? channels(1) : 0);
    return {layers(op, inputs, graph[node.outputs[0]].channels), 0};
  }
  NodeCost operator()(const Splat& op) const {
    return {layers(op.generator, channels(0) + channels(1), op.kernel * op.kernel), taps(op.kernel, 3)};
  }
  NodeCost operator()(const Gather& op) const {
    return {layers(op.generator, channels(0) + channels(1), op.kernel * op.kernel), taps(op.kernel, 3)};
  }
  NodeCost operator()(const GatherTaps& op) const { return {0, taps(op.kernel, 2)}; }
  NodeCost operator()(const Blur& op) const { return {0, taps(op.kernel, 1)}; }
};

}  // namespace

ValueExtent extent_of(const Graph& graph, ValueId id, const PictureExtent& picture) {
  const Value& value = graph[id];
  const auto side = [&](int64_t n) {
    if (value.padded) n = (n + graph.multiple - 1) / graph.multiple * graph.multiple;
    const int64_t scale = int64_t(1) << value.level;
    return (n + scale - 1) / scale;
  };
  const int64_t items = value.items == Items::samples  ? picture.samples
                        : value.items == Items::layers ? graph.layers
                                                       : 1;
  return {items * value.channels, side(picture.height), side(picture.width)};
}

std::vector<Parameter> parameters(const Graph& graph, const Node& node) {
  return std::visit(ParametersOf{graph, node}, node.op);
}

std::vector<Parameter> parameters(const Graph& graph) {
  std::vector<Parameter> all;
  std::set<std::string> names;
  for (const Node& node : graph.nodes)
    for (Parameter& parameter : parameters(graph, node))
      if (names.insert(parameter.name).second) all.push_back(std::move(parameter));
  return all;
}

int64_t count_of(const Parameter& parameter) {
  int64_t count = 1;
  for (const int64_t side : parameter.shape) count *= side;
  return count;
}

int64_t parameter_count(const Graph& graph) {
  int64_t count = 0;
  for (const Parameter& parameter : parameters(graph)) count += count_of(parameter);
  return count;
}

NodeCost cost_of(const Graph& graph, const Node& node, const PictureExtent& picture) {
  if (node.inputs.empty()) return {};
  // What passes through are the items of the input; of a fully connected network it may be the first alone.
  const ValueId passing = std::holds_alternative<FullyConnected>(node.op) ? node.outputs[0] : node.inputs[0];
  const ValueExtent extent = extent_of(graph, passing, picture);
  const int64_t items_of_pixel = extent.planes / graph[passing].channels;
  const auto items = double(items_of_pixel * extent.height * extent.width);
  NodeCost cost = std::visit(CostOf{graph, node}, node.op);
  cost.weights *= items;
  cost.taps *= items;
  return cost;
}

}  // namespace ld::graph
