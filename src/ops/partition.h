// Splatting the samples of each pixel into layers: [MH20] eq. 1 and 2, in ratios to the layer's occupancy.
#pragma once

#include <torch/torch.h>

namespace ld {

/// With w_s^l = softmax over layers of the logits and S the number of *valid* samples of the pixel,
///   w_l = 1/S sum_s w_s^l,   n_l = 1/S sum_s sum_{k >= l} w_s^k,   L_l = 1/S sum_s w_s^l L_s,   E_l alike.
/// (Eq. 2 prints k < l, but its text and appendix A mean k >= l; appendix A divides by the number of
/// samples.) n_l may underflow while the ratios to it stay of order 1, so they are computed directly and log
/// n_l is kept beside. A pixel without valid samples has log_n = -inf (it sends nothing), everything else 0,
/// and passes no gradient.
struct Partition {
  torch::Tensor log_n;          // [B, N, H, W]     log n_l; n_0 = 1
  torch::Tensor radiance;       // [B, N, 3, H, W]  L_l / n_l, premultiplied by the layer's opacity
  torch::Tensor opacity;        // [B, N, 1, H, W]  w_l / n_l
  torch::Tensor transmittance;  // [B, N, 1, H, W]  n_(l+1) / n_l = 1 - opacity without its cancellation
  torch::Tensor embedding;      // [B, N, E, H, W]  E_l, not divided by n_l
};

/// logits [B, S, N, H, W], valid [B, S, 1, H, W] (0 or not), radiance [B, S, 3, H, W], embedding [B, S, E, H,
/// W]; all float32 or all float64, finite. Differentiable in all but valid. Throws Error on shapes that do
/// not fit.
Partition partition(const torch::Tensor& logits, const torch::Tensor& valid, const torch::Tensor& radiance,
                    const torch::Tensor& embedding);

}  // namespace ld
