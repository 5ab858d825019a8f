// Structural similarity: Wang, Bovik, Sheikh and Simoncelli, "Image quality assessment: from error visibility
// to structural similarity", IEEE Transactions on Image Processing 13(4), 2004, eq. 13. Higher is better, 1
// is equal.
#pragma once

#include <string>

#include "frame/frame.h"

namespace ld {

constexpr int kSsimWindow = 11;
constexpr double kSsimSigma = 1.5;
constexpr double kSsimK1 = 0.01, kSsimK2 = 0.03;  // C = K^2, because display values range over [0, 1]

/// Mean SSIM of the display values (tone map of eq. 7 of [MH20], clamped to [0, 1]); each channel apart, then
/// averaged. Window: 11x11 Gaussian of sigma 1.5, weighted population variances, only where the whole window
/// lies inside the picture (5 pixels cropped at each border), as scikit-image has it with
/// gaussian_weights=True, use_sample_covariance=False. A picture narrower or lower than 11 uses the largest
/// odd window that fits, the Gaussian cut to it and normalised again. In [-1, 1]. Domain and errors:
/// metrics/image_pair.h.
double ssim(const Image& denoised, const Image& reference);
std::string ssim_formula();

}  // namespace ld
