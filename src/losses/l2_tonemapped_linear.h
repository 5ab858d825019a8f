// Squared error of tone-mapped values, linearised at the denoised one, "l2_tonemapped_linear": for references
// of few samples. The idea of training on noisy targets under a tone map with little bias is that of Tinits
// and Mann 2025, "Nonlinear Noise2Noise for Efficient Monte Carlo Denoiser Training" (arXiv 2512.24794), who
// look for pairs of loss and tone map whose bias is small. Here, instead, the bias is removed: the tone map
// of the target, the only term in which its noise goes through something that bends, is replaced by its
// tangent.
#pragma once

#include <torch/torch.h>

namespace ld {

/// Mean over all elements of e^2, e = T'(stop(d)) (d - r), T' the slope of the tone map T of [MH20] eq. 7
/// (core/tone_map.h), e bounded to +-kLargestRelativeError as in losses/relmse_loss.h. It is l2_tonemapped
/// with T(r) = T(d) + T'(d) (r - d): for good references and small errors the two are the same. stop(d) is d
/// held fixed: the gradient in d is 2 T'(stop(d))^2 (d - r) divided by the number of elements, and not the
/// derivative of the value. It is linear in r: over noisy targets it is zero on average exactly where d is
/// their mean. What is lost is the tone map's grip on fireflies: a target far above d weighs as much as it
/// differs, times the slope at d, 12.92 at black and 0.27 at 1. Domain: any finite d and r.
torch::Tensor l2_tonemapped_linear(const torch::Tensor& denoised, const torch::Tensor& reference);

}  // namespace ld
