#include "sequence/flow_to_next.h"

#include <algorithm>

#include "core/error.h"

namespace ld {

Image flow_to_next(const SurfaceGuides& now, const SurfaceGuides& next) {
  if (now.width != next.width || now.height != next.height)
    fail("flow: a frame of {}x{} pixels is followed by one of {}x{}; expected one size", now.width,
         now.height, next.width, next.height);
  Image flow(now.width, now.height, 2);
  std::fill(flow.pixels.begin(), flow.pixels.end(), kNoFlow);
  std::vector<float> told(flow.plane_size(), 0);  // how much who told a pixel is to be trusted
  for (int y = 0; y < next.height; ++y)
    for (int x = 0; x < next.width; ++x) {
      const size_t q = next.index(x, y);
      const float flow_x = next.flow_x[q], flow_y = next.flow_y[q];
      const float slope = depth_slope(next.depth.data(), next.width, next.height, x, y, kEscapedDepth),
                  tolerance = depth_tolerance(slope, next.depth_scale),
                  expected = next.surface[q].depth + next.flow_z[q];
      for (const BilinearTap& tap : bilinear_taps(static_cast<float>(x) + flow_x,
                                                  static_cast<float>(y) + flow_y, now.width, now.height)) {
        if (!(tap.weight > 0)) continue;
        const size_t p = now.index(tap.x, tap.y);
        const bool same = is_same_surface(next.surface[q], expected, tolerance, now.surface[p]);
        const float trust = tap.weight + (same ? 1.0F : 0.0F);
        if (!(trust > told[p])) continue;
        told[p] = trust;
        flow.plane(0)[p] = 0 - flow_x;  // and not -0
        flow.plane(1)[p] = 0 - flow_y;
      }
    }
  return flow;
}

void set_flow(Frame& frame, const Image& flow) {
  for (int s = 0; s < frame.spp; ++s)
    for (int c = 0; c < 2; ++c)
      for (size_t p = 0; p < frame.plane_size(); ++p)
        if (frame.valid_plane(s)[p] != 0) frame.plane(s, kFlowOffset + c)[p] = flow.plane(c)[p];
}

}  // namespace ld
