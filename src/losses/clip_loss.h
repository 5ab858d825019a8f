// Losses over clips: Chaitanya et al. 2017, "Interactive Reconstruction of Monte Carlo Image Sequences using
// a Recurrent Denoising Autoencoder", section 4.2 and 4.3 (their spatial, gradient and temporal loss).
#pragma once

#include <torch/torch.h>

#include <functional>
#include <vector>

#include "losses/clip_loss_config.h"
#include "losses/loss.h"

namespace ld {

/// Of B clips of T frames, folded to [B T, 3, H, W], clip after clip (dataset/input_tensors.h).
using ClipLoss =
    std::function<torch::Tensor(const torch::Tensor& denoised, const torch::Tensor& reference, int64_t clip)>;

/// With P and R the tone-mapped (eq. 7 of [MH20]) picture and reference of frame f,
///   L_f = spatial loss(d_f, r_f) + gradient mean |LoG * P_f - LoG * R_f|
///         + temporal mean |(P_f - P_(f-1)) - (R_f - R_(f-1))|,
/// the last 0 for the first frame, and the loss is sum_f w_f L_f / sum_f w_f with w_f from frame_weights().
/// (The paper takes the fifth root of linear values for the tone map; with `in_powers`, d and r are such
/// roots, and P and R are they themselves.) Changes are compared where they are,
/// without motion vectors: what moves in the reference must move alike. An error that stays the same costs
/// nothing in the temporal term, nor one that is linear across the picture in the gradient term.
/// Differentiable in the picture, value and gradient are finite wherever loss's are. A plain configuration is
/// loss(d, r) itself, bit for bit. Throws Error for pictures that cannot be folded so, and, with the gradient
/// term, for less than 15 pixels a side.
ClipLoss make_clip_loss(const ClipLossConfig& config, Loss loss, bool in_powers = false);

/// w_f = exp(-(clip - 1 - f)^2 / (2 rise^2)), or 1 for all with a rise of 0.
std::vector<double> frame_weights(int64_t clip, double rise);

/// The kernel of the gradient term, [15, 15]: G (r^2 - 2 s^2) / s^4 with a Gaussian G of s = 1.5 whose taps
/// sum to 1, less its mean, so that constants give 0. (That of the high-frequency error norm, Ravishankar and
/// Bresler 2011.)
torch::Tensor laplacian_of_gaussian(torch::ScalarType type);

}  // namespace ld
