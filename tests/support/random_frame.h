// Frames of plausible random samples, exactly representable as half floats.
#pragma once

#include <half.h>

#include "core/random.h"
#include "frame/frame.h"

namespace ld {

inline Frame random_frame(int width, int height, int spp, uint32_t seed = 1) {
  Frame frame(width, height, spp);
  RandomStream random(seed, RandomPurpose::test);
  for (int s = 0; s < spp; ++s)
    for (int c = 0; c < channel_count(frame.features); ++c)  // the first ones: those of [MH20]
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        const bool positive = c < 3 || c == kDepthOffset;
        frame.plane(s, c)[p] = static_cast<float>(half(random.uniform(positive ? 0.0F : -1.0F, 1.0F)));
      }
  frame.info.depth_scale = median_depth(frame);
  return frame;
}

}  // namespace ld
