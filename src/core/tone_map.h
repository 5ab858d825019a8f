// The tone map of [MH20] (Munkberg and Hasselgren 2020), eq. 7 and 8: the one definition behind the network's
// input, the tone-mapped loss, SSIM, PSNR and the PNGs.
#pragma once

#include <cmath>

namespace ld {

/// Gamma of eq. 8, the sRGB transfer function (Stokes et al. 1996), for x >= 0.
template <class T>
T srgb_transfer(T x) {
  return x <= T(0.0031308) ? T(12.92) * x : T(1.055) * std::pow(x, T(1) / T(2.4)) - T(0.055);
}

/// What srgb_transfer takes to y, for y >= 0.
template <class T>
T srgb_inverse(T y) {
  return y <= T(0.04045) ? y / T(12.92) : std::pow((y + T(0.055)) / T(1.055), T(2.4));
}

/// eq. 7: Gamma(log(1 + x)). Negative x counts as 0, where the printed formula is undefined below -1 and its
/// gradient NaN; log1p keeps the dark tones that log(1 + x) loses to rounding.
template <class T>
T tone_map(T x) {
  return x > T(0) ? srgb_transfer(std::log1p(x)) : T(0);
}

/// Derivative of tone_map. At and below 0 it is the slope from the right, 12.92, so that a value that went
/// negative is pulled back instead of getting stuck.
template <class T>
T tone_map_slope(T x) {
  if (!(x > T(0))) return T(12.92);
  const T y = std::log1p(x);
  const T outer = y <= T(0.0031308) ? T(12.92) : T(1.055) / T(2.4) * std::pow(y, T(1) / T(2.4) - T(1));
  return outer / (T(1) + x);
}

}  // namespace ld
