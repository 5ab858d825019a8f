// Released weights that a candidate can begin with.
#pragma once

#include <string>

#include "models/network_config.h"

namespace ld {

/// The name of released weights (weights/released.h) whose network is this one but for the features that it
/// reads, so that a training may begin with them (training/fine_tuning.h); empty where there are none.
std::string released_start(const NetworkConfig& network);

}  // namespace ld
