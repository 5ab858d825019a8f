#include "models/graphs/network_graph.h"

#include "core/error.h"

namespace ld {

graph::Graph network_graph(const NetworkConfig& config) {
  if (config.name == "layer") return layer_graph(config);
  if (config.name == "pixel_splat" || config.name == "pixel_gather" || config.name == "pixel_blend")
    return pixel_graph(config);
  if (config.name == "sample_splat") return sample_splat_graph(config);
  fail(
      "network '{}' has no graph yet; expected 'layer', 'pixel_blend', 'pixel_gather', 'pixel_splat' or "
      "'sample_splat'",
      config.name);
}

}  // namespace ld
