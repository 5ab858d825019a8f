// Frames with all that classical filters read. Link ld_frame.
#pragma once

#include "tests/support/random_frame.h"

namespace ld {

/// Random samples, exactly representable in files, the parts' sum too; a cut. Pixel 0 of sample 0 escaped.
inline Frame frame_with_filter_guides(int width, int height, int spp, uint32_t seed = 1) {
  const Frame usual = random_frame(width, height, spp, seed);
  Frame frame(width, height, spp, kAllChannels);
  frame.features = feature_names();
  frame.info.depth_scale = usual.info.depth_scale;
  RandomStream random(seed, RandomPurpose::test, 1);
  const size_t pixels = frame.plane_size();
  for (int s = 0; s < spp; ++s) {
    std::copy_n(usual.plane(s, 0), size_t{kFlowOffset} * pixels, frame.plane(s, 0));
    for (size_t p = 0; p < pixels; ++p) {
      for (int c = 0; c < 2; ++c) frame.plane(s, kFlowOffset + c)[p] = kNoFlow;
      frame.plane(s, kIdOffset)[p] = static_cast<float>(1 + random.below(3000));
      frame.plane(s, kFlowDepthOffset)[p] = static_cast<float>(half(random.uniform(-1, 1)));
      for (int c = 0; c < 3; ++c) {
        float sum = 0;
        for (const int offset : {kDirectOffset, kIndirectOffset, kEmissionOffset}) {
          const float part = static_cast<float>(random.below(256)) / 256;
          frame.plane(s, offset + c)[p] = part;
          sum += part;
        }
        frame.plane(s, c)[p] = sum;
      }
    }
  }
  frame.plane(0, kDepthOffset)[0] = kEscapedDepth;
  frame.plane(0, kIdOffset)[0] = frame.plane(0, kFlowDepthOffset)[0] = 0;
  const CameraPlace place = {{1, 2, 3}, {0.6, 0, -0.8}, {0, 1, 0}, {0.8, 0, 0.6}};
  frame.info.world_to_camera = world_to_camera(place);
  frame.info.world_to_ndc = world_to_ndc(place, 0.75, 0.5);
  frame.info.cut = true;
  return frame;
}

}  // namespace ld
