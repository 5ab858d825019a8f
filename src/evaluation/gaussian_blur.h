// The simplest denoiser there is: the baseline that every network has to beat.
#pragma once

#include "frame/frame.h"

namespace ld {

/// Convolves each channel of linear radiance with a Gaussian of deviation `sigma` pixels, cut at 3 sigma. At
/// the border the weights inside the picture are normalised again, so a constant picture stays as it is. Sums
/// in double. A NaN or an infinity spreads over the window. Throws Error when sigma is not a number above 0.
Image gaussian_blur(const Image& image, double sigma);

}  // namespace ld
