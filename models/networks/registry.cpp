// Which networks there are.
#include <functional>
#include <map>

#include "models/networks/layer_network.h"
#include "models/networks/optimized_network.h"
#include "models/networks/pixel_network.h"
#include "models/networks/sample_splat_network.h"

namespace ld {
namespace {

using Maker = std::function<std::shared_ptr<Network>(const NetworkConfig&)>;

template <class T>
std::shared_ptr<Network> make(const NetworkConfig& config) {
  return std::make_shared<T>(config);
}

/// A new network is one line here, one in check_network.cpp and one file beside this.
const std::map<std::string, Maker>& registry() {
  static const std::map<std::string, Maker> networks = {
      {"layer", make<LayerNetwork>},
      {"optimized", make<OptimizedNetwork>},
      {"pixel_gather", make<PixelGatherNetwork>},
      {"pixel_splat", make<PixelSplatNetwork>},
      {"sample_splat", make<SampleSplatNetwork>},
  };
  return networks;
}

}  // namespace

std::shared_ptr<Network> make_network(const NetworkConfig& config) {
  check_network(config);
  return registry().at(config.name)(config);
}

}  // namespace ld
