#include "losses/smape_l2.h"

#include "losses/l2_tonemapped.h"
#include "losses/smape_loss.h"

namespace ld {

torch::Tensor smape_l2_loss(const torch::Tensor& denoised, const torch::Tensor& reference) {
  return smape_loss(denoised, reference) + l2_tonemapped(denoised, reference);
}

}  // namespace ld
