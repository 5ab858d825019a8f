#include "models/graphs/layered_graph.h"
#include "models/graphs/network_graph.h"

namespace ld {

graph::Graph layer_graph(const NetworkConfig& config) {
  graph::Graph graph;
  const LayeredGraph made = add_layers(graph, config);
  const graph::ValueId context = made.features[0];
  const graph::ValueId picture =
      add_filter_and_composite(graph, config, "kernel_generator", made.layers, context);
  graph.output = add_modulation(graph, picture, made.modulators, context);
  return graph;
}

}  // namespace ld
