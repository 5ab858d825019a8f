#include "losses/smape_multiscale.h"

#include "losses/smape_loss.h"

namespace ld {
namespace {

using torch::Tensor;

/// [P, H, W] -> [P, ceil(H / 2), ceil(W / 2)]. Quarters are added: the sum of four of the largest floats
/// would overflow.
Tensor halve(const Tensor& pictures) {
  const Tensor even = at::replication_pad2d(pictures, {0, pictures.size(2) % 2, 0, pictures.size(1) % 2});
  return at::avg_pool2d(0.25 * even, 2, 2, 0, /*ceil_mode=*/false, /*count_include_pad=*/false,
                        /*divisor_override=*/1);
}

Tensor as_pictures(const Tensor& values) {
  return values.dim() < 2 ? values.view({1, 1, -1}) : values.reshape({-1, values.size(-2), values.size(-1)});
}

}  // namespace

Tensor smape_multiscale_loss(const Tensor& denoised, const Tensor& reference) {
  Tensor d = as_pictures(denoised), r = as_pictures(reference);
  Tensor sum = smape_loss(d, r);
  for (int scale = 1; scale < kSmapeScales; ++scale) {
    d = halve(d);
    r = halve(r);
    sum = sum + smape_loss(d, r);
  }
  return sum / kSmapeScales;
}

}  // namespace ld
