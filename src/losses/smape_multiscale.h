// SMAPE of the pictures and of smaller forms of them, "smape_multiscale".
#pragma once

#include <torch/torch.h>

namespace ld {

/// Full, half, quarter and eighth resolution.
inline constexpr int kSmapeScales = 4;

/// Mean of smape_loss() at kSmapeScales resolutions, each pixel of one the mean of 2x2 of the one before (an
/// odd border repeated). Blotches wider than a pixel, which SMAPE alone counts like grain that nobody sees,
/// count at every scale; and noise of the reference averages out in the coarser ones, so that what is learnt
/// of it is nearer its mean than the median-like value that SMAPE takes. Domain and bounds are
/// smape_loss()'s. The last two dimensions are height and width; a tensor of one dimension is a row.
torch::Tensor smape_multiscale_loss(const torch::Tensor& denoised, const torch::Tensor& reference);

}  // namespace ld
