// What a new run begins with.
#pragma once

#include <filesystem>
#include <memory>

#include "models/network.h"
#include "training/run/config.h"

namespace ld {

/// Copies the weights of `model` (a weight file, checkpoint or run) into the network, which must have the
/// same layers but may read fewer, more or reordered features: the first layer of the sample reducer takes
/// its columns by the names of the features' channels. Columns of features that `model` does not know are 0.
/// Features that only `model` knows are dropped: the network computes what `model` does where they are 0.
/// Throws Error naming the first parameter that does not fit.
void begin_with_weights(const std::filesystem::path& model, Network& network);

/// The network that a run begins with. Its weights are random and decided by the seed; with `with_init`, they
/// come from what the configuration's `init` names, if it names anything. They are on run.device.
std::shared_ptr<Network> make_initial_network(const TrainConfig& config, bool with_init);

}  // namespace ld
