// What a network's configuration must fulfil, for those who look at one without LibTorch.
#pragma once

#include <string>
#include <vector>

#include "models/network_config.h"

namespace ld {

/// What has a kernel of its own: layers of samples, samples, or pixels, of which mean and variance are read.
enum class Sources { layers, samples, pixels };

/// What all that know networks from outside need to know of one: checks, counts, costs, exports.
struct NetworkTraits {
  Sources sources;
  bool has_levels;  // works at several resolutions, with a kernel generator for each
  bool splats;      // its sources send, so that one can be rejected; else pixels gather
};

/// Throws UsageError for a name that is not in models/networks.def.
const NetworkTraits& network_traits(const std::string& name);

/// Throws UsageError for an unknown name or sizes that do not fit together, as make_network() does, without
/// making anything: a configuration may come from a damaged file.
void check_network(const NetworkConfig& config);

/// What make_network() (models/network.h) knows, in alphabetical order.
std::vector<std::string> network_names();

}  // namespace ld
