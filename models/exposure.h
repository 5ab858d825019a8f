// Exposure normalisation: radiance as the network sees it, at the same brightness whatever the scene's units.
#pragma once

#include <torch/torch.h>

#include "models/network_config.h"
#include "models/network_input.h"

namespace ld {

/// The exposure of each picture, [B] float64, from radiance [B, S, 3, H, W] and valid [B, S, 1, H, W]:
///   0.18 / exp(mean over pixels with Y > 0 of log Y),  Y the mean luminance of the pixel's valid samples
/// (Rec. 709), which makes the log-average luminance middle grey (Reinhard et al. 2002, eq. 1 and 2, without
/// their offset); 1 where no pixel has light. Samples with a NaN or infinity count as not valid, negative
/// radiance as 0. Radiance times 2^k gives exactly 2^-k times the exposure, another factor to rounding. One
/// firefly moves it by its logarithm over the number of pixels.
torch::Tensor exposure_of(const torch::Tensor& radiance, const torch::Tensor& valid);

/// The input with its feature "radiance" replaced by the tone map (eq. 7) of the exposed radiance; unchanged
/// where the network does not read that feature. The kernels act on the radiance as it is, so that the result
/// needs no scaling back. Samples have been sanitised; exposure [B] as above.
NetworkInput with_exposure(NetworkInput input, const torch::Tensor& exposure, const NetworkConfig& config);

}  // namespace ld
