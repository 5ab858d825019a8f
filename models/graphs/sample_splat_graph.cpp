#include "models/graphs/network_graph.h"
#include "models/graphs/shared_graph.h"

namespace ld {

using graph::Graph;
using graph::Items;
using graph::ValueId;

Graph sample_splat_graph(const NetworkConfig& config, const graph::LightParts& parts) {
  Graph graph;
  GraphInput input = add_input(graph, config, parts);
  const std::optional<ValueId> modulators = add_demodulation(graph, config, input);
  const int64_t colours = graph[input.radiance].channels;
  const ValueId features = graph.add(graph::FirstValid{}, {input.features, input.valid},
                                     {"valid_features", Items::samples, graph[input.features].channels});
  const ValueId embedding = add_reducer(graph, config, features);
  const ValueId mean = graph.add(graph::MaskedMean{}, {embedding, input.valid},
                                 {"mean", Items::picture, graph[embedding].channels});
  const ValueId context = add_unet(graph, config.unet, mean);
  ValueId log_n = graph.add(graph::LogValid{}, {input.valid}, {"log_n", Items::samples, 1});
  log_n = add_rejection(graph, config, log_n, embedding, context);
  const ValueId picture =
      graph.add(make_splat(config, /*joint=*/true), {embedding, context, log_n, input.radiance},
                {"filtered", Items::picture, colours});
  graph.output = add_modulation(graph, picture, modulators, context);
  return graph;
}

}  // namespace ld
