#include "models/networks/registry.h"

#include <map>

namespace ld {

std::shared_ptr<Network> make_network(const NetworkConfig& config) {
  static const std::map<std::string, std::shared_ptr<Network> (*)(const NetworkConfig&)> makers = {
#define LD_NETWORK(name, make, traits) {name, make},
#include "models/networks.def"
#undef LD_NETWORK
  };
  check_network(config);
  return makers.at(config.name)(config);
}

}  // namespace ld
