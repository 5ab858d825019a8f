// Compositing of the filtered layers ([MH20] section 3).
#pragma once

#include <torch/torch.h>

namespace ld {

/// eq. 5, front to back with premultiplied radiance: o = L_0 + sum_l L_l prod_{j < l} (1 - alpha_j), layers 0
/// to N-1 (the paper prints 1 to N). radiance [B, N, 3, H, W] is filtered L_l over filtered n_l,
/// transmittance [B, N, 1, H, W] is 1 - alpha_l computed as filtered n_(l+1) over filtered n_l, which does
/// not cancel behind a nearly opaque layer; that of the last layer is not used. Result [B, 3, H, W].
inline torch::Tensor composite_alpha(const torch::Tensor& radiance, const torch::Tensor& transmittance) {
  torch::Tensor color = radiance.select(1, 0);
  torch::Tensor visible = transmittance.select(1, 0);  // what the layers in front let through
  for (int64_t l = 1; l < radiance.size(1); ++l) {
    color = color + visible * radiance.select(1, l);
    visible = visible * transmittance.select(1, l);
  }
  return color;
}

}  // namespace ld
