// The layers of a network, and the kernels of a pixel, for looking.
#pragma once

#include <vector>

#include "inference/denoiser.h"
#include "models/network_config.h"
#include "runtime/executor.h"

namespace ld {

/// From the outputs of layer_views_graph() (models/graphs/network_graph.h).
std::vector<LayerPicture> layer_pictures(const NetworkConfig& config, const std::vector<Image>& outputs);

/// The kernels [1, K, K] of the pixel's layers, as shares of all that it sends; all 0 for a pixel without
/// samples. `execution` is of layer_sources_graph().
std::vector<Image> layer_kernels(const NetworkConfig& config, const NamedWeights& weights,
                                 Execution& execution, const Frame& frame, int x, int y);

}  // namespace ld
