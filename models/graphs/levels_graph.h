// What the graphs of networks with several resolutions share ([MH20] section 6).
#pragma once

#include <functional>

#include "models/graphs/layered_graph.h"

namespace ld {

/// models/networks/layer_pyramid.h. Pixels without layers are one.
struct GraphLevel {
  GraphLayers layers;
  graph::ValueId pixels;
};

/// `level`, the finest, and those below it, each filtered by `filtered(level, its number)`, blended by
/// logits [1, levels] (models/level_blend.h).
graph::ValueId add_blended_levels(graph::Graph& graph, const NetworkConfig& config, graph::ValueId logits,
                                  GraphLevel level,
                                  const std::function<graph::ValueId(const GraphLevel&, size_t)>& filtered);

}  // namespace ld
