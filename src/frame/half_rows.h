// Rows of half floats to and from floats, with the processor's own conversions (Highway, chosen at run time).
#pragma once

#include <half.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "frame/half_range.h"

namespace ld {

/// The one definition of how floats become the half floats of files: the nearest, ties to even; beyond
/// +-kHalfMax that. NaN and infinities stay, so that the sample is masked on reading.
inline half to_half(float value) {
  return half(std::isfinite(value) ? std::clamp(value, -kHalfMax, kHalfMax) : value);
}

/// The bits of IEEE half floats to floats; exact.
void half_to_float(const uint16_t* half_bits, float* values, size_t count);

/// To the nearest half float, ties to even; beyond half's range to +-65504. No NaN.
void float_to_half(const float* values, uint16_t* half_bits, size_t count);

/// Bytes of a chunk of an OpenEXR file from differences of neighbours, plus 128, to what they are.
void undo_differences(uint8_t* bytes, size_t count);

/// Half floats whose low and high bytes stand apart, to floats; exact.
void split_half_to_float(const uint8_t* low, const uint8_t* high, float* values, size_t count);

}  // namespace ld
