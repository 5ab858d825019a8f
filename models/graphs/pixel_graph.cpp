#include "frame/schema.h"
#include "models/graphs/network_graph.h"
#include "models/graphs/shared_graph.h"

namespace ld {

using graph::Graph;
using graph::Items;
using graph::ValueId;

namespace {

/// One sample a pixel: the mean of those that count (models/pixel_mean.h).
GraphInput add_pixel_mean(Graph& graph, const NetworkConfig& config, const GraphInput& input) {
  const int64_t channels = graph[input.features].channels;
  GraphInput mean{};
  mean.radiance =
      graph.add(graph::MaskedMean{}, {input.radiance, input.valid}, {"mean_radiance", Items::picture, 3});
  mean.valid = graph.add(graph::AnyValid{}, {input.valid}, {"drawn", Items::picture, 1});
  mean.features = graph.add(graph::MaskedMean{}, {input.features, input.valid},
                            {"mean_features", Items::picture, channels});
  if (const int64_t first = first_channel(config.features, "radiance"); first >= 0)
    mean.features = graph.add(graph::ToneMapped{first}, {mean.features, mean.radiance, mean.valid},
                              {"seen", Items::picture, channels});
  return mean;
}

}  // namespace

Graph pixel_graph(const NetworkConfig& config) {
  Graph graph;
  GraphInput input = add_input(graph, config);
  if (config.means) input = add_pixel_mean(graph, config, input);
  const ValueId statistics = graph.add(graph::Statistics{}, {input.features, input.valid},
                                       {"statistics", Items::picture, 2 * graph[input.features].channels});
  const ValueId embedding = add_reducer(graph, config, statistics);
  const ValueId context = add_unet(graph, config.unet, embedding);

  const std::optional<ValueId> modulators = add_demodulation(graph, config, input);
  const int64_t colours = graph[input.radiance].channels;
  const ValueId radiance = graph.add(graph::MaskedMean{}, {input.radiance, input.valid},
                                     {"pixel_radiance", Items::picture, colours});
  const ValueId drawn = graph.add(graph::AnyValid{}, {input.valid}, {"drawn", Items::picture, 1});
  ValueId log_n = graph.add(graph::LogValid{}, {drawn}, {"log_n", Items::picture, 1});
  log_n = add_rejection(graph, config, log_n, embedding, context);
  const graph::Splat splat = make_splat(config, /*joint=*/false);
  const std::vector<ValueId> read = {embedding, context, log_n, radiance};
  const graph::Value filtered = {"filtered", Items::picture, colours};
  const ValueId picture = config.name == "pixel_gather"
                              ? graph.add(graph::Gather{splat.generator, splat.kernel}, read, filtered)
                              : graph.add(splat, read, filtered);
  graph.output = add_modulation(graph, picture, modulators, context);
  return graph;
}

}  // namespace ld
