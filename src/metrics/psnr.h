// Peak signal-to-noise ratio in decibels on tone-mapped values, as [MH20] (Munkberg and Hasselgren 2020)
// reports it: higher is better.
#pragma once

#include <string>

#include "frame/frame.h"

namespace ld {

/// 10 log10(1 / MSE), MSE the mean over pixels and channels of the squared difference of the display values
/// (tone map of eq. 7, clamped to [0, 1]; peak 1). Plus infinity for pictures that look equal. Domain and
/// errors: metrics/image_pair.h.
double psnr(const Image& denoised, const Image& reference);
std::string psnr_formula();

}  // namespace ld
