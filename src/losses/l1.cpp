#include "losses/l1.h"

#include <limits>

namespace ld {

torch::Tensor l1(const torch::Tensor& denoised, const torch::Tensor& reference) {
  // Halves, and divided before they are added: d - r of opposite signs or a sum of many would overflow.
  const double scale = 2 / double(denoised.numel());
  const double largest = denoised.scalar_type() == torch::kFloat32 ? std::numeric_limits<float>::max()
                                                                   : std::numeric_limits<double>::max();
  return ((0.5 * denoised - 0.5 * reference).abs() * scale).sum().clamp_max(largest);
}

}  // namespace ld
