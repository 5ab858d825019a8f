// What tests of neighbouring frames look at.
#pragma once

#include "sequence/surface_guides.h"

namespace ld {

/// A wall that faces the camera, moved by (flow_x, flow_y) pixels since the previous frame.
inline SurfaceGuides wall(int width, int height, float depth, float flow_x = 0, float flow_y = 0) {
  SurfaceGuides guides;
  guides.width = width;
  guides.height = height;
  guides.depth_scale = depth;
  guides.has_flow = true;
  const size_t count = size_t(width) * size_t(height);
  guides.surface.assign(count, SeenSurface{depth, 0, 0, 1, 0});
  guides.depth.assign(count, depth);
  guides.flow_x.assign(count, flow_x);
  guides.flow_y.assign(count, flow_y);
  guides.flow_z.assign(count, 0);
  return guides;
}

}  // namespace ld
