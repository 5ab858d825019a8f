// Mean absolute error on linear values, "l1".
#pragma once

#include <torch/torch.h>

namespace ld {

/// Mean of |d - r| over all elements. Domain: any finite d and r; neither a difference nor the sum of many
/// large ones overflows (a mean beyond the largest number of the type counts as that). Its gradient at d = r
/// is taken as 0. A firefly weighs as much as it differs: no tone map and no division tames it.
torch::Tensor l1(const torch::Tensor& denoised, const torch::Tensor& reference);

}  // namespace ld
