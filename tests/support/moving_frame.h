// Frames of a sequence in which most pixels find their surface in the frame before.
#pragma once

#include "tests/support/random_frame.h"

namespace ld {

/// Frame `number` of a slanted plane with a step in its depth, random light, and flow of up to a pixel.
inline Frame moving_frame(int width, int height, int spp, uint32_t number) {
  Frame frame = random_frame(width, height, spp, 50 + number);
  frame.features.emplace_back("flow");
  RandomStream random(90 + number, RandomPurpose::test);
  for (int s = 0; s < spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p) {
      const int x = int(p) % width;
      frame.plane(s, kDepthOffset)[p] =
          (x > width / 2 ? 8.0F : 4.0F) + 0.01F * float(x) + 0.1F * random.uniform(0.0F, 1.0F);
      for (int c = 0; c < 3; ++c)
        frame.plane(s, kNormalOffset + c)[p] = (c == 2 ? 1.0F : 0.0F) + random.uniform(-0.1F, 0.1F);
      for (int c = 0; c < 2; ++c) frame.plane(s, kFlowOffset + c)[p] = random.uniform(-1.0F, 1.0F);
      for (const char* name : {"albedo", "specular"})
        for (int c = 0; c < 3; ++c) {
          float& value = frame.plane(s, find_feature(name).offset + c)[p];
          value = std::max(value, 0.0F);
        }
    }
  frame.info.depth_scale = median_depth(frame);
  return frame;
}

}  // namespace ld
