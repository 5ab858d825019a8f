// The training losses, by name.
#pragma once

#include <torch/torch.h>

#include <functional>
#include <string>

#include "losses/loss_names.h"

namespace ld {

/// Scalar loss of a denoised image against its reference, both [B, 3, H, W] (any equal shapes), linear
/// radiance, float32 or float64; differentiable in the denoised image (two losses hold a part of their
/// formula fixed, which their headers explain: relative_l2, l2_tonemapped_linear). Value and gradient are
/// finite for all finite values, denormals, the largest floats and negative ones included. A NaN or an
/// infinity is not looked for here, and a loss may hide it: the samples are masked and references checked
/// where they are read. A reference on another device is taken to that of the denoised image. Throws Error
/// when shapes or types differ.
using Loss = std::function<torch::Tensor(const torch::Tensor& denoised, const torch::Tensor& reference)>;

/// Throws UsageError with the nearest name when there is no such loss.
Loss make_loss(const std::string& name);

}  // namespace ld
