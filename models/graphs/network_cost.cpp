#include "models/graphs/network_cost.h"

#include <variant>

#include "graph/extent.h"
#include "models/graphs/network_graph.h"

namespace ld {
namespace {

bool starts_with(const std::string& text, const std::string& beginning) {
  return text.rfind(beginning, 0) == 0;
}

/// Adds what a node costs to its stage. What is not named here belongs to the network's own filter.
struct AddCost {
  const graph::Graph& graph;
  const graph::Node& node;
  const graph::NodeCost of_node;
  NetworkCost& cost;

  template <class Op>
  void operator()(const Op&) const {
    cost.filtering += of_node.weights + of_node.taps;
  }
  void operator()(const graph::Convolution&) const { cost.unet += of_node.weights; }
  void operator()(const graph::Splat&) const { add_filter(); }
  void operator()(const graph::Gather&) const { add_filter(); }
  void operator()(const graph::FullyConnected& op) const {
    if (op.weights == "sample_reducer") {
      cost.reducer += of_node.weights;
      const std::vector<graph::Parameter> parameters = graph::parameters(graph, node);
      double first = 0, all = 0;
      for (const graph::Parameter& parameter : parameters) {
        if (parameter.shape.size() < 2) continue;
        const auto weights = double(parameter.shape[0] * parameter.shape[1]);
        if (all == 0) first = weights;
        all += weights;
      }
      cost.first_layer = of_node.weights * first / all;
    } else if (op.weights == "sample_partitioner") {
      cost.partitioner += of_node.weights;
    } else if (starts_with(op.weights, "kernel_generator")) {
      cost.kernel_generator += of_node.weights;
    } else {
      cost.filtering += of_node.weights;
    }
  }
  void add_filter() const {
    cost.kernel_generator += of_node.weights;
    cost.filtering += of_node.taps;
  }
};

}  // namespace

NetworkCost multiply_adds(const NetworkConfig& config, int64_t spp, int64_t height, int64_t width) {
  const graph::Graph graph = network_graph(config);
  NetworkCost cost;
  for (const graph::Node& node : graph.nodes)
    std::visit(AddCost{graph, node, graph::cost_of(graph, node, {spp, height, width}), cost}, node.op);
  return cost;
}

}  // namespace ld
