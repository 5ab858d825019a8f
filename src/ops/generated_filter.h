// Kernel generator and filter in one: what each network does with the kernels that it predicts.
#pragma once

#include <torch/torch.h>

#include "ops/fully_connected.h"

namespace ld {

/// The kernel of every pixel comes from `generator` (K*K outputs, not activated; a bound applies) applied to
/// x [B, N, X, H, W] and the shared features [B, Y, H, W], and is applied at once: without a gradient to
/// keep, the K*K logits exist for a few hundred pixels at a time only (2.4 GB a layer at 1920x1080 with 17x17
/// taps otherwise). log_n, values and result as in ops/kernel_splat.h and ops/kernel_gather.h (there N = 1: x
/// [B, 1, X, H, W]).
torch::Tensor generated_splat(const FullyConnectedWeights& generator, const torch::Tensor& x,
                              const torch::Tensor& shared, const torch::Tensor& log_n,
                              const torch::Tensor& values);
torch::Tensor generated_splat_joint(const FullyConnectedWeights& generator, const torch::Tensor& x,
                                    const torch::Tensor& shared, const torch::Tensor& log_n,
                                    const torch::Tensor& values);
torch::Tensor generated_gather(const FullyConnectedWeights& generator, const torch::Tensor& x,
                               const torch::Tensor& shared, const torch::Tensor& log_n,
                               const torch::Tensor& values);

}  // namespace ld
