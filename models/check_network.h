// What a network's configuration must fulfil, for those who look at one without LibTorch.
#pragma once

#include <string>
#include <vector>

#include "models/network_config.h"

namespace ld {

/// Throws UsageError for an unknown name or sizes that do not fit together, as make_network() does, without
/// making anything: a configuration may come from a damaged file.
void check_network(const NetworkConfig& config);

/// What make_network() (models/network.h) knows, in alphabetical order.
std::vector<std::string> network_names();

}  // namespace ld
