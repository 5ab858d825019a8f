// What the graphs of networks share: sample reducer, U-net ([MH20] figures 2 and 3). Names of weights are
// those of the modules in models/.
#pragma once

#include <optional>

#include "graph/graph.h"
#include "models/network_config.h"

namespace ld {

/// The frame as a network sees it. With the radiance come parts of the light (graph::Value::parts).
struct GraphInput {
  graph::ValueId features, radiance, valid;
};
GraphInput add_input(graph::Graph& graph, const NetworkConfig& config, const graph::LightParts& parts = {});

/// x and the context -> the outputs of a fully connected network; its result has as many items as x.
graph::ValueId add_fully_connected(graph::Graph& graph, const graph::FullyConnected& op, graph::ValueId x,
                                   std::optional<graph::ValueId> context = std::nullopt);

/// Outputs of the hidden layers and of the last one.
std::vector<int64_t> with_last(std::vector<int64_t> hidden, int64_t last);

/// A reducer's layers, the last one activated.
graph::ValueId add_reducer(graph::Graph& graph, const NetworkConfig& config, graph::ValueId features);

/// Of the samples that count.
graph::ValueId add_mean_radiance(graph::Graph& graph, const GraphInput& input, const char* name);

/// One sample a pixel: the mean of those that count (models/pixel_mean.h).
GraphInput add_pixel_mean(graph::Graph& graph, const NetworkConfig& config, const GraphInput& input);

/// With demodulation: both forms of the radiance take its place; returns what add_modulation() needs.
std::optional<graph::ValueId> add_demodulation(graph::Graph& graph, const NetworkConfig& config,
                                               GraphInput& input);

/// The texture that comes back, and how much of it.
graph::ValueId add_modulation_factors(graph::Graph& graph, graph::ValueId modulators, graph::ValueId context);

/// The picture from what was filtered.
graph::ValueId add_modulation(graph::Graph& graph, graph::ValueId filtered,
                              std::optional<graph::ValueId> modulators, graph::ValueId context);

/// log n less what is rejected, where the network rejects.
graph::ValueId add_rejection(graph::Graph& graph, const NetworkConfig& config, graph::ValueId log_n,
                             graph::ValueId embedding, graph::ValueId context);

/// The splat of a kernel generator, at a level of the picture.
graph::Splat make_splat(const NetworkConfig& config, bool joint, int level = 0);

/// A picture of embeddings -> what the U-net's decoder knows at full resolution (the context C_xy), 1/2, 1/4,
/// ... (UNet::features()), of the padded picture.
std::vector<graph::ValueId> add_unet_features(graph::Graph& graph, const UNetConfig& config,
                                              graph::ValueId picture);
inline graph::ValueId add_unet(graph::Graph& graph, const UNetConfig& config, graph::ValueId picture) {
  return add_unet_features(graph, config, picture)[0];
}

}  // namespace ld
