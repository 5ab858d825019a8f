// Splatting the samples of each pixel into layers: [MH20] eq. 1 and 2, in ratios to what each layer is
// divided by when it is composited.
#pragma once

#include <torch/torch.h>

namespace ld {

/// How the layers become one picture ([MH20] section 3): front to back by their opacity (eq. 4 and 5), or as
/// one weighted mean (eq. 6).
enum class Compositing { alpha, weighted };

/// With w_s^l = softmax over layers of the logits and S the number of *valid* samples of the pixel,
///   w_l = 1/S sum_s w_s^l,   L_l = 1/S sum_s w_s^l L_s,   E_l alike, and
///   n_l = 1/S sum_s sum_{k >= l} w_s^k for alpha compositing, n_l = w_l for the weighted one.
/// (Eq. 2 prints k < l, but its text and appendix A mean k >= l; appendix A divides by the number of
/// samples.) n_l may underflow while the ratios to it stay of order 1, so they are computed directly and log
/// n_l is kept beside. A pixel without valid samples has log_n = -inf (it sends nothing), everything else 0,
/// and passes no gradient.
struct Partition {
  torch::Tensor log_n;          // [B, N, H, W]     log n_l
  torch::Tensor radiance;       // [B, N, C, H, W]  L_l / n_l
  torch::Tensor opacity;        // [B, N, 1, H, W]  w_l / n_l; 1 for the weighted compositor
  torch::Tensor transmittance;  // [B, N, 1, H, W]  n_(l+1) / n_l = 1 - opacity without its cancellation;
                                //                  undefined for the weighted compositor
  torch::Tensor embedding;      // [B, N, E, H, W]  E_l, not divided by n_l
};

/// logits [B, S, N, H, W], valid [B, S, 1, H, W] (0 or not), radiance [B, S, C, H, W] (C = 3, or more where
/// the light is filtered in several forms), embedding [B, S, E, H, W], all of one floating type. A sample
/// whose radiance is NaN or infinite counts as not valid; logits beyond a quarter of the type's range count
/// as that, NaN as the lowest. Differentiable in all but valid. The bits do not depend on the thread count.
/// Throws Error on shapes that do not fit.
Partition partition(const torch::Tensor& logits, const torch::Tensor& valid, const torch::Tensor& radiance,
                    const torch::Tensor& embedding, Compositing compositing = Compositing::alpha);

}  // namespace ld
