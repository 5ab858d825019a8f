// Symmetric mean absolute percentage error, eq. 9 of [MH20] (Munkberg and Hasselgren 2020): linear radiance,
// lower is better.
#pragma once

#include <string>

#include "frame/frame.h"

namespace ld {

constexpr double kSmapeEpsilon = 0.01;

/// mean over pixels and channels of |d - r| / (|d| + |r| + 0.01), in [0, 1] (a fraction, despite the name).
/// Domain and errors: metrics/image_pair.h.
double smape(const Image& denoised, const Image& reference);
std::string smape_formula();

}  // namespace ld
