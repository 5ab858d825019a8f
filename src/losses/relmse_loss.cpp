#include "losses/relmse_loss.h"

#include <cmath>

#include "metrics/relmse.h"

namespace ld {

torch::Tensor relmse_loss(const torch::Tensor& denoised, const torch::Tensor& reference) {
  // hypot, because r^2 of the metric's formula would overflow beyond 1.8e19.
  const torch::Tensor scale = at::hypot(reference, at::full_like(reference, std::sqrt(kRelmseEpsilon)));
  const torch::Tensor relative = (denoised - reference) / scale;
  return relative.clamp(-kLargestRelativeError, kLargestRelativeError).square().mean();
}

}  // namespace ld
