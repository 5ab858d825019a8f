#include "models/graphs/levels_graph.h"
#include "models/graphs/network_graph.h"
#include "models/graphs/shared_graph.h"

namespace ld {

using graph::Graph;
using graph::Items;
using graph::ValueId;

namespace {

/// What the filters read.
struct GraphPixels {
  ValueId embedding;
  std::vector<ValueId> features;  // of the U-net, finest first: the context
  ValueId drawn, log_n, radiance;

  ValueId context() const { return features[0]; }
};

ValueId add_kernels(Graph& graph, const NetworkConfig& config, const GraphPixels& pixels,
                    const graph::Value& filtered) {
  const graph::Splat splat = make_splat(config, /*joint=*/false);
  const std::vector<ValueId> read = {pixels.embedding, pixels.context(), pixels.log_n, pixels.radiance};
  if (config.name == "pixel_gather")
    return graph.add(graph::Gather{splat.generator, splat.kernel}, read, filtered);
  return graph.add(splat, read, filtered);
}

/// models/networks/pixel_blend_network.cpp.
ValueId add_blend(Graph& graph, const NetworkConfig& config, const GraphPixels& pixels,
                  const graph::Value& filtered) {
  graph::Value value = filtered;
  value.name = "blurred";
  const ValueId blurred =
      graph.add(graph::Blur{config.kernel_size}, {pixels.log_n, pixels.radiance}, std::move(value));
  const ValueId logit = add_fully_connected(graph, {"blend", {1}}, pixels.embedding, pixels.context());
  return graph.add(graph::Mix{}, {logit, pixels.drawn, pixels.radiance, blurred}, filtered);
}

/// PixelPyramidNetwork of models/networks/pixel_kernel_networks.cpp.
ValueId add_pyramid(Graph& graph, const NetworkConfig& config, const GraphPixels& pixels,
                    const graph::Value& filtered) {
  const ValueId logits =
      add_fully_connected(graph, {"levels.logits", {config.levels}}, pixels.embedding, pixels.context());
  const GraphLevel finest = {{pixels.log_n, pixels.embedding, pixels.radiance, {}, std::nullopt},
                             pixels.drawn};
  return add_blended_levels(graph, config, logits, finest, [&](const GraphLevel& level, size_t i) {
    graph::Splat splat = make_splat(config, /*joint=*/false, int(i));
    if (i > 0) splat.generator.weights = "levels.kernel_generator" + std::to_string(i);
    graph::Value value = filtered;
    value.level = int(i);
    return graph.add(splat,
                     {level.layers.embedding, pixels.features[i], level.layers.log_n, level.layers.radiance},
                     std::move(value));
  });
}

ValueId add_filter(Graph& graph, const NetworkConfig& config, const GraphPixels& pixels,
                   const graph::Value& filtered) {
  if (config.name == "pixel_blend") return add_blend(graph, config, pixels, filtered);
  if (config.name == "pixel_pyramid") return add_pyramid(graph, config, pixels, filtered);
  return add_kernels(graph, config, pixels, filtered);
}

}  // namespace

Graph pixel_graph(const NetworkConfig& config, const graph::LightParts& parts) {
  Graph graph;
  GraphInput input = add_input(graph, config, parts);
  if (config.means) input = add_pixel_mean(graph, config, input);
  const ValueId statistics = graph.add(graph::Statistics{}, {input.features, input.valid},
                                       {"statistics", Items::picture, 2 * graph[input.features].channels});
  const ValueId embedding = add_reducer(graph, config, statistics);
  const std::vector<ValueId> features = add_unet_features(graph, config.unet, embedding);
  const ValueId context = features[0];

  const std::optional<ValueId> modulators = add_demodulation(graph, config, input);
  GraphPixels pixels = {embedding, features, 0, 0, 0};
  pixels.radiance = add_mean_radiance(graph, input, "pixel_radiance");
  pixels.drawn = graph.add(graph::AnyValid{}, {input.valid}, {"drawn", Items::picture, 1});
  pixels.log_n =
      add_rejection(graph, config, graph.add(graph::LogValid{}, {pixels.drawn}, {"log_n", Items::picture, 1}),
                    embedding, context);
  const graph::Value filtered = {"filtered", Items::picture, graph[pixels.radiance].channels};
  const ValueId picture = add_filter(graph, config, pixels, filtered);
  graph.output = add_modulation(graph, picture, modulators, context);
  return graph;
}

}  // namespace ld
