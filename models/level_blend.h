// Pictures of falling resolution, blended to one ([MH20] section 6 and eq. 10).
#pragma once

#include <torch/torch.h>

#include <vector>

#include "models/unet.h"

namespace ld {

/// sum_i lambda_i Upscale(G_i, 2^i)   (eq. 10), upscaled as in the U-net. The paper leaves lambda_i free;
/// here they are a softmax over the levels, because nothing else keeps a constant picture constant. A level
/// that received nothing at a pixel is left out of its sum. logits [B, levels, H, W]; pictures [B, C, H /
/// 2^i, W / 2^i]; received [B, 1, H / 2^i, W / 2^i]: 1 where a level received something, else 0. Result [B,
/// C, H, W].
torch::Tensor blend_levels(const torch::Tensor& logits, const std::vector<torch::Tensor>& pictures,
                           const std::vector<torch::Tensor>& received, const UNetConfig& unet);

/// 1 where kernels of so many taps a side reach from a pixel with samples, else 0, [B, 1, H, W]: such a
/// weight is never 0, however small (ops/kernel_splat.h).
torch::Tensor received_from(const torch::Tensor& pixels, int64_t kernel);

}  // namespace ld
