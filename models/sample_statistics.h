// What the networks on pixels know of the samples: mean and variance ([MH20] appendix B).
#pragma once

#include <torch/torch.h>

#include "models/network_input.h"

namespace ld {

/// Mean and population variance of each feature over the valid samples, [B, 1, 2F, H, W], means first; 0 for
/// a pixel without any. In two passes (the variance as the mean square distance to the mean): E[x^2] - E[x]^2
/// would be negative for a third of all pixels at mean 1e4 and deviation 1. Duplicated samples change nothing
/// but rounding, and one sample has the variance 0. Differentiable in the features.
torch::Tensor sample_statistics(const torch::Tensor& features, const torch::Tensor& valid);

}  // namespace ld
