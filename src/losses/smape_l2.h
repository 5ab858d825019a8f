// Both losses of [MH20] together, "smape_l2".
#pragma once

#include <torch/torch.h>

namespace ld {

/// smape_loss() + l2_tonemapped(). SMAPE's slope falls with 1/d^2, so that it hardly sees how bright the spot
/// is that a firefly leaves; the L2 on tone-mapped values (eq. 7 and 8) does, and is small next to SMAPE
/// everywhere else. Domain and bounds are those of the two.
torch::Tensor smape_l2_loss(const torch::Tensor& denoised, const torch::Tensor& reference);

}  // namespace ld
