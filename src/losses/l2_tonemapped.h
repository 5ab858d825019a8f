// Squared error of tone-mapped values ([MH20] section 4, eq. 7), "l2_tonemapped".
#pragma once

#include <torch/torch.h>

namespace ld {

/// Mean of (x'(d) - x'(r))^2 over all elements, x' the tone map of eq. 7.
torch::Tensor l2_tonemapped(const torch::Tensor& denoised, const torch::Tensor& reference);

}  // namespace ld
