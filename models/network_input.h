// What every denoising network takes, and the one place where it is checked and made safe.
#pragma once

#include <torch/torch.h>

#include "models/network_config.h"

namespace ld {

/// A batch of frames or crops, float32 or float64.
struct NetworkInput {
  torch::Tensor features;  // [B, S, F, H, W] encoded (frame/schema.h), channels in the order of
                           // NetworkConfig::features
  torch::Tensor radiance;  // [B, S, 3, H, W] linear, >= 0; as admitted, all forms of it that are filtered:
                           // [B, S, 6, H, W] with demodulation (models/demodulation.h)
  torch::Tensor valid;     // [B, S, 1, H, W] 1 for a sample that was drawn, 0 for a missing or masked one,
                           // whose features and radiance count for nothing
  torch::Tensor demodulator = {};  // [B, S, 3, H, W] as admitted with demodulation, else undefined
};

/// What was wrong with the samples of an input, and what was done about it.
struct InputFaults {
  int64_t not_finite = 0;  // samples with a NaN or infinite feature or radiance, removed as if not drawn
  int64_t negative = 0;    // radiance channels below 0, set to 0
  int64_t clamped = 0;     // feature channels beyond +-65504, set to that: the first layer could overflow
};

/// Throws Error when a shape or type does not fit the configuration, or when there is no sample at all.
void check_input(const NetworkInput& input, const NetworkConfig& config);

/// The input with its faults removed, whose numbers `faults` receives. Differentiable. An input without
/// faults is returned as it is and costs two reductions.
NetworkInput sanitise(NetworkInput input, InputFaults& faults);

}  // namespace ld
