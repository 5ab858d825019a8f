// What the first hits of a frame say to the filters: one surface a pixel.
#pragma once

#include <limits>

#include "filters/kernels/row_planes.h"

namespace ld {

/// Planes of Surfaces::of.
enum SurfacePlane : int {
  kId,       // which object and material, a whole number; NaN where no surface is: it equals nothing
  kNormalX,  // unit; the axes are the same for all frames of a sequence (world space) where they are known
  kNormalY,
  kNormalZ,
  kDepth,      // along the view axis, in units of a tenth of the frame's depth scale
  kPositionX,  // of the surface point, same unit, relative to the camera
  kPositionY,
  kPositionZ,
  kSurfacePlanes
};

/// Lengths are in scene units.
struct Surfaces {
  RowPlanes of;  // SurfacePlane
  // Where the surface point was in the previous picture, p' = p + flow in pixels (+x right, +y down), and
  // how much deeper it was then than now.
  RowPlanes flow;
  float unit = 1;             // a tenth of FrameInfo::depth_scale: what the filters count lengths in
  bool has_flow = false;      // without it no history is ever valid
  bool has_position = false;  // without it positions are (0, 0, depth)

  Surfaces() = default;
  Surfaces(int width, int height) { resize(width, height); }

  void resize(int width, int height) {
    if (of.is(width, height, kSurfacePlanes)) return;
    of = RowPlanes(width, height, kSurfacePlanes);
    flow = RowPlanes(width, height, 3);
    of.fill_margin(kId, std::numeric_limits<float>::quiet_NaN());
  }
  int width() const { return of.width(); }
  int height() const { return of.height(); }
};

}  // namespace ld
