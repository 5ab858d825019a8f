// Where a training computes.
#pragma once

#include <torch/torch.h>

#include <string>

namespace ld {

/// The device of run.device. Throws UsageError when this LibTorch, or the machine, has no such one; `place`
/// says for that where somebody chose it. All else follows the weights: a network takes its input to them and
/// a loss its reference (models/network.h, losses/loss.h), so that nobody else needs to know.
torch::Device device_named(const std::string& name, const std::string& place = "the configuration");

}  // namespace ld
