// Networks as graphs (graph/graph.h), from their configurations alone: what models/networks/ do at inference.
#pragma once

#include "graph/graph.h"
#include "models/network_config.h"

namespace ld {

/// Of every network of models/networks.def. Its output has the picture and, behind it, what `parts` says.
/// Throws UsageError as check_network() does.
graph::Graph network_graph(const NetworkConfig& config, const graph::LightParts& parts = {});

/// Super-resolution and a denoiser (models/networks/espcn_kpcn_network.cpp). Light parts cannot be predicted:
/// throws UsageError for them.
graph::Graph espcn_kpcn_graph(const NetworkConfig& config, const graph::LightParts& parts);

/// [MH20] figure 2 (models/networks/layer_network.h).
graph::Graph layer_graph(const NetworkConfig& config, const graph::LightParts& parts);

/// Layers that remember (models/networks/layer_history_network.cpp); its state is Graph::state.
graph::Graph layer_history_graph(const NetworkConfig& config, const graph::LightParts& parts);

/// The layers of network "layer", to look at. Outputs: L_l / n_l [N, C]; what layers are filtered to [N, C +
/// 2], radiance, opacity and transmittance. With the weighted compositor they are filtered to [N, C + 1], and
/// a third output [N, 1] has the shares of the layers in the picture. C is 3, or, with demodulation, 6: both
/// forms of the radiance (models/demodulation.h), and the last output has the factors of the modulation
/// [1, 4].
graph::Graph layer_views_graph(const NetworkConfig& config);

/// What the same network's kernels are generated from: log n [N, 1], embeddings [N, E], context [1, C].
graph::Graph layer_sources_graph(const NetworkConfig& config);

/// "pixel_blend", "pixel_gather" and "pixel_splat": one filter for each pixel
/// (models/networks/pixel_network.h).
graph::Graph pixel_graph(const NetworkConfig& config, const graph::LightParts& parts);

/// A pyramid of layers ([MH20] section 6; models/networks/optimized_network.h).
graph::Graph optimized_graph(const NetworkConfig& config, const graph::LightParts& parts);

/// The recurrent denoising autoencoder (models/recurrent.h); its state is Graph::state. Throws UsageError for
/// parts of the light, which it cannot tell apart.
graph::Graph recurrent_graph(const NetworkConfig& config, const graph::LightParts& parts);

/// One kernel for each sample (models/networks/sample_splat_network.h).
graph::Graph sample_splat_graph(const NetworkConfig& config, const graph::LightParts& parts);

}  // namespace ld
