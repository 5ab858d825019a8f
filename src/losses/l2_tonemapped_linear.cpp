#include "losses/l2_tonemapped_linear.h"

#include "losses/relmse_loss.h"
#include "ops/tone_map_tensor.h"

namespace ld {

torch::Tensor l2_tonemapped_linear(const torch::Tensor& denoised, const torch::Tensor& reference) {
  // Halves: a difference of opposite signs would overflow, and infinity times a slope of 0 would be NaN.
  const torch::Tensor error = 2 * tone_map_slope(denoised) * (0.5 * denoised - 0.5 * reference);
  return error.clamp(-kLargestRelativeError, kLargestRelativeError).square().mean();
}

}  // namespace ld
