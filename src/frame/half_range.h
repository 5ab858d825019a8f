// Colours that are brighter than half floats reach.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace ld {

/// The largest finite half float: what files hold, and what features are bounded by.
constexpr float kHalfMax = 65504.0F;

/// Scales each colour of three planes of which a channel exceeds kHalfMax so that its largest is that:
/// darker, but of the same hue. Channels below -kHalfMax become that; colours that are not finite stay.
/// Returns how many channels were beyond.
inline int64_t fit_colours_in_half(float* red, float* green, float* blue, size_t count) {
  int64_t beyond = 0;
  for (size_t p = 0; p < count; ++p) {
    float* const channels[3] = {red + p, green + p, blue + p};
    float most = 0;
    bool finite = true;
    for (const float* channel : channels) {
      finite = finite && std::isfinite(*channel);
      most = std::max(most, *channel);
    }
    if (!finite) continue;
    for (float* channel : channels) {
      if (std::fabs(*channel) > kHalfMax) ++beyond;
      if (most > kHalfMax) *channel *= kHalfMax / most;
      *channel = std::clamp(*channel, -kHalfMax, kHalfMax);
    }
  }
  return beyond;
}

}  // namespace ld
