// A picture of the previous frame, moved to where its surfaces are now (as the temporal accumulation of
// Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering", HPG 2017, section 3.2, does).
#pragma once

#include <torch/torch.h>

namespace ld {

struct Warped {
  torch::Tensor values;  // [B, C, H, W]; 0 where nothing is valid
  torch::Tensor valid;   // [B, 1, H, W], 1 or 0
};

/// What pixels show in this frame and in the previous one, [B, 4, H, W] each: encoded depth and normal
/// (ops/kernels/warp_taps.h). Both or neither.
struct WarpGuides {
  torch::Tensor now, before;
};

/// values [B, C, H, W] of the previous frame and valid [B, 1, H, W] (not 0 where they count), looked up at p
/// + flow(p): flow [B, 2, H, W] in pixels, +x right, +y down, from a pixel's place to the previous frame's
/// (the feature `flow`). The result is the mean of the four pixels around that place, weighed bilinearly, of
/// those that lie inside of the picture, are valid, are finite in all channels and, with guides, may show the
/// same surface; weights are normalised over these. Where theirs sum to less than 0.01, and where the flow is
/// not finite, the result is invalid.
///
/// float32 or float64. Differentiable in `values` alone. The same bits
/// for any number of threads. On the CPU only. Throws Error on shapes that do not fit and other devices.
Warped warp(const torch::Tensor& values, const torch::Tensor& flow, const torch::Tensor& valid,
            const WarpGuides& guides = {});

}  // namespace ld
