// Relative mean squared error, as [MH20] (Munkberg and Hasselgren 2020) reports it: linear radiance, lower is
// better.
#pragma once

#include <string>

#include "frame/frame.h"

namespace ld {

/// The epsilon that [MH20]'s published code uses; the paper gives none. It decides how much black pixels
/// weigh, so it is printed with every number.
constexpr double kRelmseEpsilon = 1e-4;

/// mean over pixels and channels of (d - r)^2 / (r^2 + 1e-4). Domain and errors: metrics/image_pair.h. One
/// pixel of 65504 on black adds 4.3e13 / (3 H W), one of 3e38 adds 9e80 / (3 H W): double holds both.
double relmse(const Image& denoised, const Image& reference);
std::string relmse_formula();

}  // namespace ld
