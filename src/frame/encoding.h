// From the units of the files to what a network sees (the schema's encodings).
#pragma once

#include <cstddef>

#include "frame/schema.h"

namespace ld {

/// Encodes `count` values of one channel of `feature`; `depth_scale` is the frame's median finite depth
/// (above 0). Finite for every finite input. NaN and infinities are the business of sanitise(). `values` and
/// `encoded` may be the same.
void encode(const Feature& feature, float depth_scale, const float* values, float* encoded, size_t count);

}  // namespace ld
