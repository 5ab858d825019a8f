// What a new run begins with.
#pragma once

#include <filesystem>
#include <memory>

#include "models/network.h"
#include "training/run/config.h"

namespace ld {

/// All weights of the network that `model` has, too (weights/mix_weights.h), and says which features are new.
void begin_with_weights(const std::filesystem::path& model, Network& network);

/// The network that a run begins with. Its weights are random and decided by the seed; with `with_init`, they
/// come from what the configuration's `init` names, if it names anything. They are on run.device.
std::shared_ptr<Network> make_initial_network(const TrainConfig& config, bool with_init);

}  // namespace ld
