// Relative mean squared error on linear values, "relmse": what metrics/relmse.h measures, made safe to train
// with.
#pragma once

#include <torch/torch.h>

namespace ld {

/// A relative error beyond this counts as this and passes no gradient. float32 cannot hold the square of what
/// the formula asks for at the extremes (3e38 on black is a relative error of 3e40); the bound keeps the sum
/// over 10^20 elements finite. All that files of half floats can hold lies below: 65504 on black is 6.6e6.
constexpr double kLargestRelativeError = 1e8;

/// Mean over all elements of e^2, e = (d - r) / sqrt(r^2 + kRelmseEpsilon), bounded as above. Domain: any
/// finite d and r.
torch::Tensor relmse_loss(const torch::Tensor& denoised, const torch::Tensor& reference);

}  // namespace ld
