// Sums over the samples of a pixel: what splats samples into layers (eq. 2) and averages embeddings.
#pragma once

#include <torch/torch.h>

namespace ld {

/// out[b,l,c,y,x] = sum over s of weights[b,s,l,y,x] * values[b,s,c,y,x].
/// weights [B, S, N, H, W], values [B, S, C, H, W], result [B, N, C, H, W]; float32 or float64,
/// differentiable in both. The samples are added in their order, whatever the thread count. Throws Error on
/// shapes that do not fit.
torch::Tensor weighted_sum(const torch::Tensor& weights, const torch::Tensor& values);

/// Mean over the valid samples (valid != 0) of values [B, S, C, H, W] with valid [B, S, 1, H, W]; 0 where a
/// pixel has none. Result [B, C, H, W].
torch::Tensor masked_mean(const torch::Tensor& values, const torch::Tensor& valid);

}  // namespace ld
