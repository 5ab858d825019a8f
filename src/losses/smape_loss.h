// Symmetric mean absolute percentage error ([MH20] eq. 9, after Vogels et al. 2018), "smape".
#pragma once

#include <torch/torch.h>

namespace ld {

/// Mean of |d - r| / (|d| + |r| + 0.01) over all elements, on linear values. Its gradient at d = r is taken
/// as 0. Domain: any finite d and r, meant for d and r >= 0, as the networks give them (sums of radiance with
/// weights >= 0). For d < 0 < r the value is nearly constant, so a negative d would get stuck. A firefly
/// hardly trains: its slope falls with 1/d^2.
torch::Tensor smape_loss(const torch::Tensor& denoised, const torch::Tensor& reference);

}  // namespace ld
