#include "models/graphs/layered_graph.h"
#include "models/graphs/network_graph.h"

namespace ld {

graph::Graph layer_graph(const NetworkConfig& config, const graph::LightParts& parts) {
  graph::Graph graph;
  const LayeredGraph made = add_layers(graph, config, parts);
  const graph::ValueId context = made.features[0];
  const graph::ValueId picture =
      add_filter_and_composite(graph, config, "kernel_generator", made.layers, context);
  graph.output = add_modulation(graph, picture, made.modulators, context);
  return graph;
}

graph::Graph layer_views_graph(const NetworkConfig& config) {
  graph::Graph graph;
  const LayeredGraph made = add_layers(graph, config);
  const GraphLayers& layers = made.layers;
  const std::vector<graph::ValueId> sources = {layers.embedding, made.features[0], layers.log_n};
  const auto filter = [&](bool joint, const char* name, std::vector<graph::ValueId> values) {
    graph::Value filtered = {name, joint ? graph::Items::picture : graph::Items::layers, 0};
    for (const graph::ValueId value : values) filtered.channels += graph[value].channels;
    values.insert(values.begin(), sources.begin(), sources.end());
    return graph.add(make_splat(config, joint), std::move(values), std::move(filtered));
  };
  graph.output = layers.radiance;
  if (layers.transmittance) {
    graph.further = {filter(false, "filtered", {layers.radiance, layers.opacity, *layers.transmittance})};
  } else {
    const graph::ValueId belongs =
        graph.add(graph::LayerIdentity{}, {}, {"belongs", graph::Items::layers, config.layers});
    graph.further = {filter(false, "filtered", {layers.radiance, layers.opacity}),
                     filter(true, "shares", {belongs})};
  }
  if (made.modulators)
    graph.further.push_back(add_modulation_factors(graph, *made.modulators, made.features[0]));
  return graph;
}

graph::Graph layer_sources_graph(const NetworkConfig& config) {
  graph::Graph graph;
  const LayeredGraph made = add_plain_layers(graph, config);
  graph.output = made.layers.log_n;
  graph.further = {made.layers.embedding, made.features[0]};
  return graph;
}

}  // namespace ld
