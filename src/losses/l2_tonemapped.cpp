#include "losses/l2_tonemapped.h"

#include "ops/tone_map_tensor.h"

namespace ld {

torch::Tensor l2_tonemapped(const torch::Tensor& denoised, const torch::Tensor& reference) {
  return (tone_map(denoised) - tone_map(reference)).square().mean();
}

}  // namespace ld
