#include "runtime/unit.h"

#include <algorithm>

namespace ld {
namespace {

using graph::Graph;
using graph::Node;
using graph::ValueId;

void add_once(std::vector<ValueId>& list, ValueId id) {
  if (std::find(list.begin(), list.end(), id) == list.end()) list.push_back(id);
}

class Grouping {
 public:
  explicit Grouping(const Graph& graph) : graph_(graph), producer_(graph.values.size()) {
    for (size_t n = 0; n < graph.nodes.size(); ++n) {
      const Node& node = graph.nodes[n];
      const size_t unit = place_of(node);
      if (unit == nodes_.size()) nodes_.emplace_back();
      nodes_[unit].push_back(n);
      for (const ValueId output : node.outputs) producer_[output] = unit;
    }
  }

  std::vector<Unit> units() const {
    std::vector<Unit> units;
    for (const std::vector<size_t>& nodes : nodes_) units.push_back({nodes, {}, {}});
    for (size_t u = 0; u < units.size(); ++u)
      for (const size_t n : units[u].nodes)
        for (const ValueId input : graph_.nodes[n].inputs)
          if (producer_[input] != u) {
            add_once(units[u].inputs, input);
            add_once(units[producer_[input]].outputs, input);
          }
    std::vector<ValueId> kept = graph_.outputs();
    kept.insert(kept.end(), graph_.state.begin(), graph_.state.end());
    for (const ValueId output : kept) add_once(units[producer_[output]].outputs, output);
    // What works on rows writes all of its outputs, those that nobody reads, too.
    for (Unit& unit : units)
      if (const Node& only = graph_.nodes[unit.nodes[0]]; !graph::is_pixelwise(only.op))
        for (const ValueId output : only.outputs) add_once(unit.outputs, output);
    return units;
  }

 private:
  bool alike(ValueId a, ValueId b) const {
    return graph_[a].level == graph_[b].level && graph_[a].padded == graph_[b].padded;
  }

  /// The youngest unit that the node can join, or a new one.
  size_t place_of(const Node& node) const {
    size_t place = nodes_.size();
    if (!graph::is_pixelwise(node.op)) return place;
    for (const ValueId input : node.inputs) {
      const size_t unit = producer_[input];
      const Node& first = graph_.nodes[nodes_[unit][0]];
      const bool fits = graph::is_pixelwise(first.op) && alike(first.outputs[0], node.outputs[0]) &&
                        std::none_of(node.inputs.begin(), node.inputs.end(), [&](ValueId other) {
                          return producer_[other] != unit && reads(producer_[other], unit);
                        });
      if (fits && (place == nodes_.size() || unit > place)) place = unit;
    }
    return place;
  }

  /// Whether a unit reads what another puts out, itself or through others.
  bool reads(size_t unit, size_t other) const {
    for (const size_t n : nodes_[unit])
      for (const ValueId input : graph_.nodes[n].inputs)
        if (producer_[input] == other || (producer_[input] != unit && reads(producer_[input], other)))
          return true;
    return false;
  }

  const Graph& graph_;
  std::vector<size_t> producer_;            // unit of each value
  std::vector<std::vector<size_t>> nodes_;  // of each unit
};

}  // namespace

std::vector<Unit> units_of(const Graph& graph) {
  return Grouping(graph).units();
}

}  // namespace ld
