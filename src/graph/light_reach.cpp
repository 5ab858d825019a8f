#include "graph/light_reach.h"

#include <algorithm>
#include <variant>

namespace ld::graph {
namespace {

using Reach = std::optional<LightReach>;

const Node& producer_of(const Graph& graph, ValueId id) {
  return *std::find_if(graph.nodes.begin(), graph.nodes.end(), [&](const Node& node) {
    return std::find(node.outputs.begin(), node.outputs.end(), id) != node.outputs.end();
  });
}

/// Of the first output of `node`, or of its radiance.
struct ReachOf {
  const Graph& graph;
  const Node& node;

  Reach through(size_t input, int64_t kernel = 1) const {
    const Node& from = producer_of(graph, node.inputs[input]);
    Reach reach = std::visit(ReachOf{graph, from}, from.op);
    if (reach) {
      reach->radius += kernel / 2;
      reach->additions += kernel * (kernel + 4);  // taps, and what is done for each row of them
    }
    return reach;
  }

  template <class Op>
  Reach operator()(const Op&) const {
    return std::nullopt;
  }
  Reach operator()(const Encode&) const { return LightReach{}; }
  Reach operator()(const Demodulate& op) const {
    Reach reach = through(1);
    if (reach) {
      reach->albedo = op.albedo >= 0;
      reach->specular = op.specular >= 0;
    }
    return reach;
  }
  Reach operator()(const MaskedMean&) const { return through(0); }
  Reach operator()(const Partition&) const { return through(2); }
  Reach operator()(const Splat& op) const {
    Reach reach = through(3, op.kernel);
    const Items items = graph[node.inputs[3]].items;
    if (reach && op.joint && items == Items::layers) reach->layers = graph.layers;
    if (reach && op.joint && items == Items::samples) reach->samples = true;
    return reach;
  }
  Reach operator()(const Gather& op) const { return through(3, op.kernel); }
  Reach operator()(const Blur& op) const { return through(1, op.kernel); }
  Reach operator()(const Mix&) const {
    const Reach first = through(2), second = through(3);
    if (!first || !second) return std::nullopt;
    return first->radius > second->radius ? first : second;
  }
  Reach operator()(const Composite&) const { return through(0); }
  Reach operator()(const Modulate&) const { return through(0); }
};

}  // namespace

std::optional<LightReach> light_reach(const Graph& graph) {
  const Node& last = producer_of(graph, graph.output);
  return std::visit(ReachOf{graph, last}, last.op);
}

}  // namespace ld::graph
