// Relative squared error whose scale does not see the target, "relative_l2": for references of few samples.
// Lehtinen et al. 2018, "Noise2Noise", section 3.3 (the loss for renderings of high dynamic range); epsilon
// as in Mueller et al. 2021, "Real-time Neural Radiance Caching for Path Tracing".
#pragma once

#include <torch/torch.h>

namespace ld {

/// Beside d^2: below |d| = 0.1 errors count as they are, times 100. Lehtinen et al. have (|d| + 0.01)^2, with
/// which a noisy target on black weighs 10^4 times one on white.
constexpr double kRelativeL2Epsilon = 0.01;

/// Mean over all elements of e^2, e = (d - r) / sqrt(stop(d)^2 + kRelativeL2Epsilon), bounded to
/// +-kLargestRelativeError as in losses/relmse_loss.h. stop(d) is d held fixed: the gradient in d is
/// 2 (d - r) / (stop(d)^2 + epsilon) divided by the number of elements, and not the derivative of the value.
/// It is linear in r: over noisy targets it is zero on average exactly where d is their mean, whatever their
/// distribution. (Not held fixed, the scale would draw d upwards; with r in its place, as relMSE has it, the
/// minimum is far below the mean.) Domain: any finite d and r.
torch::Tensor relative_l2(const torch::Tensor& denoised, const torch::Tensor& reference);

}  // namespace ld
