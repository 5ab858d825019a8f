// The layered denoiser (models/networks/layer_network.h) as a graph.
#pragma once

#include "graph/graph.h"
#include "models/network_config.h"

namespace ld {

/// [MH20] figure 2. Throws Error for what the runtime has no operator for yet: `exposure_normalisation` and
/// `means`.
graph::Graph layer_graph(const NetworkConfig& config);

}  // namespace ld
