// The tone map of [MH20] (Munkberg and Hasselgren 2020), eq. 7 and 8: the one definition behind the network's
// input, the tone-mapped loss, SSIM, PSNR and the PNGs.
#pragma once

#include <algorithm>
#include <cmath>

namespace ld {

/// The sRGB transfer function: kSrgbSlope x up to kSrgbLinearTo, kSrgbScale x^(1 / kSrgbExponent) -
/// kSrgbOffset beyond.
template <class T>
constexpr T kSrgbLinearTo = T(0.0031308);
template <class T>
constexpr T kSrgbSlope = T(12.92);
template <class T>
constexpr T kSrgbScale = T(1.055);
template <class T>
constexpr T kSrgbOffset = T(0.055);
template <class T>
constexpr T kSrgbExponent = T(2.4);

/// Gamma of eq. 8, the sRGB transfer function (Stokes et al. 1996), for x >= 0.
template <class T>
T srgb_transfer(T x) {
  return x <= kSrgbLinearTo<T> ? kSrgbSlope<T> * x
                               : kSrgbScale<T> * std::pow(x, T(1) / kSrgbExponent<T>) - kSrgbOffset<T>;
}

/// What srgb_transfer takes to y, for y >= 0.
template <class T>
T srgb_inverse(T y) {
  return y <= T(0.04045) ? y / kSrgbSlope<T>
                         : std::pow((y + kSrgbOffset<T>) / kSrgbScale<T>, kSrgbExponent<T>);
}

/// eq. 7: Gamma(log(1 + x)). Negative x counts as 0, where the printed formula is undefined below -1 and its
/// gradient NaN; log1p keeps the dark tones that log(1 + x) loses to rounding.
template <class T>
T tone_map(T x) {
  return x > T(0) ? srgb_transfer(std::log1p(x)) : T(0);
}

/// What tone_map() takes to y, for y up to tone_map(kHalfMax) = 2.82: larger ones count as that, so that an
/// exponential does not overflow, negative ones and NaN as 0.
template <class T>
T tone_map_inverse(T y) {
  if (!(y > T(0))) return T(0);
  return std::min(std::expm1(srgb_inverse(std::min(y, T(3)))), T(65504));
}

/// Derivative of tone_map. At and below 0 it is the slope from the right, 12.92, so that a value that went
/// negative is pulled back instead of getting stuck.
template <class T>
T tone_map_slope(T x) {
  if (!(x > T(0))) return kSrgbSlope<T>;
  const T y = std::log1p(x);
  const T power = T(1) / kSrgbExponent<T>;
  const T outer =
      y <= kSrgbLinearTo<T> ? kSrgbSlope<T> : kSrgbScale<T> / kSrgbExponent<T> * std::pow(y, power - T(1));
  return outer / (T(1) + x);
}

}  // namespace ld
