// The functions of networks.def, each in the file of its network.
#pragma once

#include <memory>

#include "models/network.h"

namespace ld {

#define LD_NETWORK(name, make, traits) std::shared_ptr<Network> make(const NetworkConfig& config);
#include "models/networks.def"
#undef LD_NETWORK

}  // namespace ld
