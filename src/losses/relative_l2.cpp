#include "losses/relative_l2.h"

#include <cmath>

#include "losses/relmse_loss.h"

namespace ld {

torch::Tensor relative_l2(const torch::Tensor& denoised, const torch::Tensor& reference) {
  // hypot, because d^2 would overflow beyond 1.8e19; halves, because a difference of opposite signs would.
  const torch::Tensor held = denoised.detach();
  const torch::Tensor scale = 0.5 * at::hypot(held, at::full_like(held, std::sqrt(kRelativeL2Epsilon)));
  const torch::Tensor relative = (0.5 * denoised - 0.5 * reference) / scale;
  return relative.clamp(-kLargestRelativeError, kLargestRelativeError).square().mean();
}

}  // namespace ld
