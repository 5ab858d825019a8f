#include "losses/smape_loss.h"

#include "metrics/smape.h"

namespace ld {

torch::Tensor smape_loss(const torch::Tensor& denoised, const torch::Tensor& reference) {
  // Halves throughout: |d| + |r| of two values near the largest float would overflow.
  const torch::Tensor d = 0.5 * denoised, r = 0.5 * reference;
  return ((d - r).abs() / (d.abs() + r.abs() + 0.5 * kSmapeEpsilon)).mean();
}

}  // namespace ld
