// The weights of one network in another.
#pragma once

#include <filesystem>
#include <string>

#include "models/network.h"

namespace ld {

/// Every parameter p of the network that `model` (a weight file, checkpoint or run) has, too, as q, becomes
/// p + share (q - p). With a share of 1 that is what a training begins with. In between it is what fine
/// tuning learnt without all that it forgot: the mean of the weights before and after (Wortsman et al. 2022,
/// Robust fine-tuning of zero-shot models). The layers must be the same, but `model` may know fewer, more or
/// reordered features: the first layer of the sample reducer takes its columns by the names of the features'
/// channels. Columns of features that `model` does not know are 0 there; features that only `model` knows are
/// dropped: the network computes what `model` does where they are 0. `model` may also lack what begins
/// without effect (rejection, history): there the network keeps its own. Throws UsageError that begins with
/// `who` and names the first parameter that does not fit.
void mix_in_weights(const std::filesystem::path& model, double share, Network& network,
                    const std::string& who);

}  // namespace ld
