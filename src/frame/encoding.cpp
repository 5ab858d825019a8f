#include "frame/encoding.h"

#include <algorithm>
#include <cmath>

#include "core/tone_map.h"

namespace ld {

void encode(const Feature& feature, float depth_scale, const float* values, float* encoded, size_t count) {
  switch (feature.encoding) {
    case Encoding::tone_map:
      for (size_t i = 0; i < count; ++i) encoded[i] = tone_map(values[i]);
      return;
    case Encoding::identity:
      // Linear layers follow: 3e38 would overflow the first of them.
      for (size_t i = 0; i < count; ++i) encoded[i] = std::clamp(values[i], -kEscapedDepth, kEscapedDepth);
      return;
    case Encoding::depth:
      for (size_t i = 0; i < count; ++i) {
        const float depth = std::max(values[i], 0.0F);
        encoded[i] = depth >= kEscapedDepth ? 1.0F : depth / (depth + depth_scale);
      }
      return;
    case Encoding::squash:
      for (size_t i = 0; i < count; ++i) encoded[i] = values[i] / (std::fabs(values[i]) + feature.scale);
      return;
    case Encoding::place:
      for (size_t i = 0; i < count; ++i) encoded[i] = values[i] / (std::fabs(values[i]) + depth_scale);
      return;
    case Encoding::none:
      require_network_feature(feature.name);
  }
}

}  // namespace ld
