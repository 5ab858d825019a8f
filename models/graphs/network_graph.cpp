#include "models/graphs/network_graph.h"

#include "core/error.h"
#include "models/check_network.h"

namespace ld {

graph::Graph network_graph(const NetworkConfig& config, const graph::LightParts& parts) {
  check_network(config);
  if (config.name == "espcn_kpcn") return espcn_kpcn_graph(config, parts);
  if (config.name == "layer") return layer_graph(config, parts);
  if (config.name == "layer_history") return layer_history_graph(config, parts);
  if (config.name == "optimized") return optimized_graph(config, parts);
  if (config.name == "pixel_blend" || config.name == "pixel_gather" || config.name == "pixel_pyramid" ||
      config.name == "pixel_splat")
    return pixel_graph(config, parts);
  if (config.name == "recurrent") return recurrent_graph(config, parts);
  if (config.name == "sample_splat") return sample_splat_graph(config, parts);
  fail("network '{}' has no graph; each of models/networks.def has a line here", config.name);
}

}  // namespace ld
