// What every metric does with its two pictures before it compares them: one definition of the domain.
//
// Domain of all metrics: denoised and reference are [3, H, W], linear scene-referred radiance, H and W at
// least 1.
//   - Any finite float is fine, up to 3.4e38 and down to denormals: sums and squares are taken in double.
//     (Programs that let the CPU flush denormals, as those with LibTorch do, see 1e-39 as 0, which no score
//     can tell.)
//   - relMSE and SMAPE take negative values as they are; on tone-mapped values (PSNR, SSIM) they count as
//     black.
//   - A NaN or an infinity anywhere in the denoised picture makes every metric NaN. Were each pixel to follow
//     its formula, the clamp of the tone map would turn it into plain black or white, and a broken denoiser
//     would score like a good one.
//   - A NaN or an infinity in the reference, sizes that differ, another number of channels or no pixel at
//     all: Error.
#pragma once

#include <cstdint>
#include <vector>

#include "frame/frame.h"

namespace ld {

/// How many of the values are NaN or infinite.
int64_t count_not_finite(const Image& image);

/// Throws Error as stated above; returns whether the denoised picture is finite, that is, whether it has a
/// score.
bool comparable(const Image& denoised, const Image& reference);

/// The picture as it is shown: tone map of [MH20], eq. 7 and 8 (core/tone_map.h), clamped to [0, 1]. Finite
/// values only.
std::vector<double> display_values(const Image& image);

}  // namespace ld
