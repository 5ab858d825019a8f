// The tone map of core/tone_map.h on rows of pixels, float32, for every SIMD width (Highway).
#pragma once

#include <cstdint>

namespace ld {

/// out[i] = tone_map(x[i]) to a relative error of 1e-6. An infinite x counts as the largest
/// float. `out` may be `x`.
void tone_map_row(const float* x, float* out, int64_t count);

}  // namespace ld
