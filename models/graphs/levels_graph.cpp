#include "models/graphs/levels_graph.h"

#include <utility>

namespace ld {

using graph::Graph;
using graph::ValueId;

namespace {

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

}  // namespace

ValueId add_blended_levels(Graph& graph, const NetworkConfig& config, ValueId logits, GraphLevel level,
                           const std::function<ValueId(const GraphLevel&, size_t)>& filtered) {
  std::vector<ValueId> read = {logits};
  for (int64_t i = 0; i < config.levels; ++i) {
    if (i > 0) level = add_halved(graph, level);
    const ValueId picture = filtered(level, size_t(i));
    const ValueId received = graph.add(graph::Received{config.kernel_size}, {level.pixels},
                                       {"received", graph::Items::picture, 1, int(i)});
    for (const ValueId id : {picture, received}) read.push_back(add_upscaled(graph, config, id));
  }
  graph::Value blended = graph[read[1]];
  blended.name = "blended";
  return graph.add(graph::BlendLevels{}, std::move(read), std::move(blended));
}

}  // namespace ld
