// How a frame is exposed before a network sees its radiance.
#pragma once

#include <algorithm>

#include "frame/frame.h"

namespace ld {

/// The exposure of models/exposure.h. The frame has been sanitised. Depends on no number of threads.
double frame_exposure(const Frame& frame, int threads);

/// Radiance times the exposure, at most half's largest number. In doubles: neither an exposure of 1e37 nor
/// radiance of 3e38 leaves their range.
inline void expose_row(const float* radiance, double exposure, float* out, int64_t count) {
  for (int64_t x = 0; x < count; ++x)
    out[x] = float(std::min(double(radiance[x]) * exposure, double(kHalfMax)));
}

}  // namespace ld
