#include "models/graphs/layered_graph.h"

namespace ld {

using graph::Graph;
using graph::Items;
using graph::ValueId;

namespace {

/// eq. 1 and 2.
GraphLayers add_partition(Graph& graph, const NetworkConfig& config, const GraphInput& input,
                          ValueId embedding, ValueId context) {
  const bool alpha = config.compositing == "alpha";
  const ValueId logits = add_fully_connected(
      graph, {"sample_partitioner", with_last(config.sample_partitioner, config.layers)}, embedding, context);
  const auto value = [&](const char* name, int64_t channels) {
    return graph.add_value({name, Items::layers, channels});
  };
  GraphLayers layers{};
  layers.log_n = value("log_n", 1);
  layers.radiance = value("layer_radiance", graph[input.radiance].channels);
  graph.values[layers.radiance].parts = graph[input.radiance].parts;
  layers.opacity = value("opacity", 1);
  layers.embedding = value("layer_embedding", graph[embedding].channels);
  std::vector<ValueId> outputs = {layers.log_n, layers.radiance, layers.opacity, layers.embedding};
  if (alpha) outputs.push_back(*(layers.transmittance = value("transmittance", 1)));
  graph.nodes.push_back({graph::Partition{alpha}, {logits, input.valid, input.radiance, embedding}, outputs});
  return layers;
}

LayeredGraph add_layers_of(Graph& graph, const NetworkConfig& config, GraphInput input, bool demodulate) {
  graph.layers = config.layers;
  LayeredGraph made{};
  made.samples = input.features;
  made.valid = input.valid;
  const ValueId embedding = add_reducer(graph, config, input.features);
  const ValueId mean = graph.add(graph::MaskedMean{}, {embedding, input.valid},
                                 {"mean", Items::picture, graph[embedding].channels});
  made.features = add_unet_features(graph, config.unet, mean);
  if (demodulate) made.modulators = add_demodulation(graph, config, input);
  const ValueId context = made.features[0];
  made.layers = add_partition(graph, config, input, embedding, context);
  made.layers.log_n = add_rejection(graph, config, made.layers.log_n, made.layers.embedding, context);
  return made;
}

}  // namespace

LayeredGraph add_layers(Graph& graph, const NetworkConfig& config, const graph::LightParts& parts) {
  return add_layers_of(graph, config, add_input(graph, config, parts), /*demodulate=*/true);
}

LayeredGraph add_plain_layers(Graph& graph, const NetworkConfig& config) {
  return add_layers_of(graph, config, add_input(graph, config), /*demodulate=*/false);
}

ValueId add_filter_and_composite(Graph& graph, const NetworkConfig& config, const std::string& generator,
                                 const GraphLayers& layers, ValueId context) {
  const bool alpha = layers.transmittance.has_value();
  const int64_t colours = graph[layers.radiance].channels;
  const int level = graph[layers.radiance].level;
  graph::Splat splat = make_splat(config, /*joint=*/!alpha, level);
  splat.generator.weights = generator;
  std::vector<ValueId> read = {layers.embedding, context, layers.log_n, layers.radiance};
  if (!alpha) return graph.add(splat, std::move(read), {"filtered", Items::picture, colours, level});
  read.push_back(*layers.transmittance);
  const ValueId filtered = graph.add(splat, std::move(read), {"filtered", Items::layers, colours + 1, level});
  return graph.add(graph::Composite{}, {filtered}, {"composited", Items::picture, colours, level});
}

}  // namespace ld
