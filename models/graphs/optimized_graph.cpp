#include "models/graphs/levels_graph.h"
#include "models/graphs/network_graph.h"

namespace ld {

using graph::Graph;
using graph::Items;
using graph::ValueId;

namespace {

/// The logits of lambda_i: the outputs behind the taps of the finest generator, for layer 0.
ValueId add_level_logits(Graph& graph, const NetworkConfig& config, const std::string& generator,
                         ValueId embedding, ValueId context) {
  graph::FullyConnected op = make_splat(config, /*joint=*/false).generator;
  op.weights = generator;
  op.bound = 0;
  op.first_output = config.kernel_size * config.kernel_size;
  return graph.add(op, {embedding, context}, {"level_logits", Items::picture, config.levels});
}

}  // namespace

Graph optimized_graph(const NetworkConfig& config, const graph::LightParts& parts) {
  Graph graph;
  const LayeredGraph made = add_layers(graph, config, parts);
  const ValueId context = made.features[0];
  const auto generator = [](size_t level) { return "kernel_generator" + std::to_string(level); };
  const ValueId logits = add_level_logits(graph, config, generator(0), made.layers.embedding, context),
                pixels = graph.add(graph::AnyValid{}, {made.valid}, {"pixels", Items::picture, 1});
  const ValueId picture = add_blended_levels(
      graph, config, logits, {made.layers, pixels}, [&](const GraphLevel& level, size_t i) {
        return add_filter_and_composite(graph, config, generator(i), level.layers, made.features[i]);
      });
  graph.output = add_modulation(graph, picture, made.modulators, context);
  return graph;
}

}  // namespace ld
