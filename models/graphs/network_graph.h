// Networks as graphs (graph/graph.h), from their configurations alone: what models/networks/ do at inference.
#pragma once

#include "graph/graph.h"
#include "models/network_config.h"

namespace ld {

/// Of every network of models/networks.def. Throws Error for another name.
graph::Graph network_graph(const NetworkConfig& config);

/// [MH20] figure 2 (models/networks/layer_network.h).
graph::Graph layer_graph(const NetworkConfig& config);

/// "pixel_blend", "pixel_gather" and "pixel_splat": one filter for each pixel
/// (models/networks/pixel_network.h).
graph::Graph pixel_graph(const NetworkConfig& config);

/// A pyramid of layers ([MH20] section 6; models/networks/optimized_network.h).
graph::Graph optimized_graph(const NetworkConfig& config);

/// One kernel for each sample (models/networks/sample_splat_network.h).
graph::Graph sample_splat_graph(const NetworkConfig& config);

}  // namespace ld
