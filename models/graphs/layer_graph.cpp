#include "models/graphs/network_graph.h"
#include "models/graphs/shared_graph.h"

namespace ld {

using graph::Graph;
using graph::Items;
using graph::Value;
using graph::ValueId;

namespace {

/// What the partition puts out.
struct GraphLayers {
  ValueId log_n, radiance, opacity, embedding, transmittance;
};

GraphLayers add_partition(Graph& graph, const NetworkConfig& config, const GraphInput& input,
                          ValueId embedding, ValueId context, bool alpha) {
  const ValueId logits =
      add_fully_connected(graph, {"sample_partitioner", int64_t(config.sample_partitioner.size()) + 1},
                          config.layers, embedding, context);
  const auto value = [&](const char* name, int64_t channels) {
    return graph.add_value({name, Items::layers, channels});
  };
  GraphLayers layers{};
  layers.log_n = value("log_n", 1);
  layers.radiance = value("layer_radiance", graph[input.radiance].channels);
  layers.opacity = value("opacity", 1);
  layers.embedding = value("layer_embedding", graph[embedding].channels);
  std::vector<ValueId> outputs = {layers.log_n, layers.radiance, layers.opacity, layers.embedding};
  if (alpha) outputs.push_back(layers.transmittance = value("transmittance", 1));
  graph.nodes.push_back({graph::Partition{alpha}, {logits, input.valid, input.radiance, embedding}, outputs});
  return layers;
}

}  // namespace

Graph layer_graph(const NetworkConfig& config) {
  const bool alpha = config.compositing == "alpha";
  Graph graph;
  graph.layers = config.layers;

  GraphInput input = add_input(graph, config);
  const ValueId embedding = add_reducer(graph, config, input.features);
  const ValueId mean = graph.add(graph::MaskedMean{}, {embedding, input.valid},
                                 {"mean", Items::picture, graph[embedding].channels});
  const ValueId context = add_unet(graph, config.unet, mean);

  const std::optional<ValueId> modulators = add_demodulation(graph, config, input);
  const int64_t colours = graph[input.radiance].channels;
  const GraphLayers layers = add_partition(graph, config, input, embedding, context, alpha);
  const ValueId log_n = add_rejection(graph, config, layers.log_n, layers.embedding, context);
  ValueId picture = 0;
  if (alpha) {
    const ValueId filtered =
        graph.add(make_splat(config, /*joint=*/false),
                  {layers.embedding, context, log_n, layers.radiance, layers.transmittance},
                  {"filtered", Items::layers, colours + 1});
    picture = graph.add(graph::Composite{}, {filtered}, {"composited", Items::picture, colours});
  } else {
    picture =
        graph.add(make_splat(config, /*joint=*/true), {layers.embedding, context, log_n, layers.radiance},
                  {"filtered", Items::picture, colours});
  }
  graph.output = add_modulation(graph, picture, modulators, context);
  return graph;
}

}  // namespace ld
