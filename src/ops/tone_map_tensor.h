// The tone map of [MH20] eq. 7 and 8 on tensors, differentiable.
#pragma once

#include <torch/torch.h>

namespace ld {

/// Elementwise tone_map() of core/tone_map.h; its derivative is tone_map_slope(), finite everywhere. float32
/// or float64, any shape. Throws Error for another element type.
torch::Tensor tone_map(const torch::Tensor& linear);

/// Elementwise tone_map_inverse() of core/tone_map.h; its derivative is 1 / tone_map_slope() of the result
/// everywhere, so that a value outside of its range is pulled back and not stuck.
torch::Tensor tone_map_inverse(const torch::Tensor& mapped);

/// Elementwise tone_map_slope(), without a gradient of its own.
torch::Tensor tone_map_slope(const torch::Tensor& linear);

}  // namespace ld
