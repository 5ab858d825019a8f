// The one definition of how floats become the half floats of files.
#pragma once

#include <half.h>

#include <algorithm>
#include <cmath>

#include "frame/half_range.h"

namespace ld {

/// The nearest half float, ties to even; beyond +-kHalfMax that. NaN and infinities stay, so that the sample
/// is masked on reading.
inline half to_half(float value) {
  return half(std::isfinite(value) ? std::clamp(value, -kHalfMax, kHalfMax) : value);
}

}  // namespace ld
