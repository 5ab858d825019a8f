#include "models/graphs/layered_graph.h"
#include "models/graphs/network_graph.h"

namespace ld {

using graph::Graph;
using graph::Items;
using graph::ValueId;

namespace {

/// models/networks/layer_pyramid.h.
struct GraphLevel {
  GraphLayers layers;
  ValueId pixels;
};

GraphLevel add_halved(Graph& graph, const GraphLevel& fine) {
  std::vector<ValueId> inputs = {fine.layers.log_n, fine.pixels, fine.layers.embedding, fine.layers.radiance};
  if (fine.layers.transmittance) inputs.push_back(*fine.layers.transmittance);
  std::vector<ValueId> outputs;
  for (const ValueId id : inputs) {
    graph::Value value = graph[id];
    ++value.level;
    outputs.push_back(graph.add_value(std::move(value)));
  }
  graph.nodes.push_back({graph::Halve{}, std::move(inputs), outputs});
  GraphLevel coarse = {{outputs[0], outputs[2], outputs[3], {}, std::nullopt}, outputs[1]};
  if (fine.layers.transmittance) coarse.layers.transmittance = outputs[4];
  return coarse;
}

/// A picture of any level at full resolution.
ValueId add_upscaled(Graph& graph, const NetworkConfig& config, ValueId id) {
  graph::Value value = graph[id];
  if (value.level == 0) return id;
  const graph::Upsample op = {config.unet.upsampling == "bilinear", value.level};
  value.name = "upscaled";
  value.level = 0;
  return graph.add(op, {id}, std::move(value));
}

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
  const auto generator = [](int64_t level) { return "kernel_generator" + std::to_string(level); };
  std::vector<ValueId> read = {add_level_logits(graph, config, generator(0), made.layers.embedding, context)};
  GraphLevel level = {made.layers, graph.add(graph::AnyValid{}, {made.valid}, {"pixels", Items::picture, 1})};
  for (int64_t i = 0; i < config.levels; ++i) {
    if (i > 0) level = add_halved(graph, level);
    const ValueId picture =
        add_filter_and_composite(graph, config, generator(i), level.layers, made.features[size_t(i)]);
    const ValueId received = graph.add(graph::Received{config.kernel_size}, {level.pixels},
                                       {"received", Items::picture, 1, int(i)});
    for (const ValueId id : {picture, received}) read.push_back(add_upscaled(graph, config, id));
  }
  graph::Value blended = graph[read[1]];
  blended.name = "blended";
  const ValueId picture = graph.add(graph::BlendLevels{}, std::move(read), std::move(blended));
  graph.output = add_modulation(graph, picture, made.modulators, context);
  return graph;
}

}  // namespace ld
