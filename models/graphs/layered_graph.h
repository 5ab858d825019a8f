// What the graphs of the networks with layers share ([MH20] section 3).
#pragma once

#include <string>
#include <vector>

#include "models/graphs/shared_graph.h"

namespace ld {

/// What a filter reads of the layers.
struct GraphLayers {
  graph::ValueId log_n, embedding, radiance, opacity;
  std::optional<graph::ValueId> transmittance;  // with alpha compositing
};

/// Everything before the filters.
struct LayeredGraph {
  graph::ValueId samples, valid;         // their features, and which there are
  std::vector<graph::ValueId> features;  // of the U-net, finest first: the context
  std::optional<graph::ValueId> modulators;
  GraphLayers layers;
};
LayeredGraph add_layers(graph::Graph& graph, const NetworkConfig& config,
                        const graph::LightParts& parts = {});
/// For looking: their radiance is that of the samples, whatever the network filters.
LayeredGraph add_plain_layers(graph::Graph& graph, const NetworkConfig& config);

/// Kernels from such a generator, at the layers' resolution, and the compositor (eq. 3 to 6;
/// models/compositor.h).
graph::ValueId add_filter_and_composite(graph::Graph& graph, const NetworkConfig& config,
                                        const std::string& generator, const GraphLayers& layers,
                                        graph::ValueId context);

}  // namespace ld
