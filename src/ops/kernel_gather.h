// Filtering by gathering: the kernel of a pixel weighs what the pixel receives (PixelGather of [MH20] section
// 5; Bako et al. 2017, eq. 6 and 7).
#pragma once

#include <torch/torch.h>

namespace ld {

/// Tap i*K + j of pixel (y, x) reads pixel (y + i - r, x + j - r), r = (K-1)/2. With the sums over the taps
/// inside the picture,
///   out(q) = sum_p n(p) exp(logit(q,p)) v(p) / sum_p n(p) exp(logit(q,p)),
/// evaluated as a softmax over logit + log n, the largest of which is taken out first.
///
/// logits [B, K*K, H, W], log_n [B, H, W] (0, or -inf for a pixel that has nothing to give), values
/// [B, C, H, W], result [B, C, H, W], 0 where nothing is in reach. What is not finite counts as in
/// ops/kernel_splat.h. Differentiable in logits and values, not in log_n. The bits do not depend on the
/// thread count. Throws Error on shapes that do not fit.
torch::Tensor kernel_gather(const torch::Tensor& logits, const torch::Tensor& log_n,
                            const torch::Tensor& values);

}  // namespace ld
