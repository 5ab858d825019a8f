// Makes the networks of networks.def.
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

const std::map<std::string, Maker>& registry() {
  static const std::map<std::string, Maker> networks = {
#define LD_NETWORK(name, type, traits) {name, make<type>},
#include "models/networks.def"
#undef LD_NETWORK
  };
  return networks;
}

}  // namespace

std::shared_ptr<Network> make_network(const NetworkConfig& config) {
  check_network(config);
  return registry().at(config.name)(config);
}

}  // namespace ld
