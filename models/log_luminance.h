// The log-average luminance of a picture, and the exposure that makes it middle grey. Free of LibTorch.
#pragma once

#include <cmath>
#include <cstdint>

#include "models/network_numbers.h"

namespace ld {

/// Rec. 709, of numbers or tensors.
template <class T>
T luminance(const T& red, const T& green, const T& blue) {
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
}

/// The sum of log2 of the pixels' luminances, taken apart into whole exponents and mantissas, so that a power
/// of two changes the exponents alone.
class LogLuminance {
 public:
  /// The mean luminance of a pixel's valid samples; a pixel without light does not count.
  void add(double mean) {
    if (!(mean > 0)) return;
    int exponent = 0;
    mantissas_ += std::log2(std::frexp(mean, &exponent));
    exponents_ += exponent;
    ++pixels_;
  }

  /// The pixels of another part of the picture.
  void add(const LogLuminance& other) {
    mantissas_ += other.mantissas_;
    exponents_ += other.exponents_;
    pixels_ += other.pixels_;
  }

  /// 0.18 / exp(mean of log Y); 1 where no pixel has light.
  double exposure() const {
    if (pixels_ == 0) return 1;
    // The mean is whole + fraction: a power of two in the radiance changes `whole` and nothing else.
    int64_t whole = exponents_ / pixels_, rest = exponents_ % pixels_;
    if (rest < 0) {
      rest += pixels_;
      --whole;
    }
    const double fraction = (double(rest) + mantissas_) / double(pixels_);
    return std::ldexp(kMiddleGrey * std::exp2(-fraction), int(-whole));
  }

 private:
  int64_t pixels_ = 0, exponents_ = 0;
  double mantissas_ = 0;  // log2, each in [-1, 0)
};

}  // namespace ld
