// Filtering and compositing of the layers ([MH20] section 3 and 3.1).
#pragma once

#include <torch/torch.h>

#include "ops/generated_filter.h"
#include "ops/partition.h"

namespace ld {

/// eq. 5, front to back with premultiplied radiance: o = L_0 + sum_l L_l prod_{j < l} (1 - alpha_j), layers 0
/// to N-1 (the paper prints 1 to N). radiance [B, N, C, H, W] is filtered L_l over filtered n_l,
/// transmittance [B, N, 1, H, W] is 1 - alpha_l computed as filtered n_(l+1) over filtered n_l, which does
/// not cancel behind a nearly opaque layer; that of the last layer is not used. Result [B, C, H, W].
inline torch::Tensor composite_alpha(const torch::Tensor& radiance, const torch::Tensor& transmittance) {
  torch::Tensor color = radiance.select(1, 0);
  torch::Tensor visible = transmittance.select(1, 0);  // what the layers in front let through
  for (int64_t l = 1; l < radiance.size(1); ++l) {
    color = color + visible * radiance.select(1, l);
    visible = visible * transmittance.select(1, l);
  }
  return color;
}

/// The second half of figure 2: kernels from the layers' embeddings and the context [B, C, H, W], eq. 3 and
/// 4, and the compositor that the partition was made for: eq. 5, or the weighted sum of eq. 6, which is sum
/// L-bar_l over sum w-bar_l (as printed it would weigh by w twice). Result [B, C, H, W].
inline torch::Tensor filter_and_composite(const FullyConnectedWeights& generator, const Partition& layers,
                                          const torch::Tensor& context, Compositing compositing) {
  if (compositing == Compositing::weighted)
    return generated_splat_joint(generator, layers.embedding, context, layers.log_n, layers.radiance);
  const torch::Tensor filtered = generated_splat(generator, layers.embedding, context, layers.log_n,
                                                 at::cat({layers.radiance, layers.transmittance}, 2));
  const int64_t channels = layers.radiance.size(2);
  return composite_alpha(filtered.narrow(2, 0, channels), filtered.narrow(2, channels, 1));
}

}  // namespace ld
