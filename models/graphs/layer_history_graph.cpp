#include "frame/schema.h"
#include "models/graphs/layered_graph.h"
#include "models/graphs/network_graph.h"
#include "models/network_numbers.h"

namespace ld {

using graph::Items;
using graph::ValueId;

graph::Graph layer_history_graph(const NetworkConfig& config, const graph::LightParts& parts) {
  graph::Graph graph;
  const LayeredGraph made = add_layers(graph, config, parts);
  const ValueId context = made.features[0];
  const ValueId now = add_filter_and_composite(graph, config, "kernel_generator", made.layers, context);
  const int64_t channels = graph[now].channels;

  const ValueId past = graph.add_value({"past", Items::picture, channels}),
                frames = graph.add_value({"past_frames", Items::picture, 1}),
                surface = graph.add_value({"surface", Items::picture, 4});
  const auto first = [&](const char* feature) { return first_channel(config.features, feature); };
  graph.nodes.push_back({graph::Recall{first("flow"), first("depth"), first("normal")},
                         {made.samples, made.valid},
                         {past, frames, surface}});
  const ValueId seen =
      graph.add(graph::Compare{kComparedRadius}, {now, past, frames}, {"compared", Items::picture, 3});
  const ValueId logit =
      add_fully_connected(graph, {"history.gate", with_last(config.history, 1)}, seen, context);
  const ValueId drawn = graph.add(graph::AnyValid{}, {made.valid}, {"drawn", Items::picture, 1});
  const ValueId light = graph.add_value({"remembered", Items::picture, channels}),
                counted = graph.add_value({"frames", Items::picture, 1});
  graph.nodes.push_back({graph::Remember{}, {logit, now, past, frames, drawn}, {light, counted}});
  graph.state = {light, counted, surface};
  graph.output = add_modulation(graph, light, made.modulators, context);
  return graph;
}

}  // namespace ld
