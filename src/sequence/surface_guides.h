// One surface a pixel out of a frame's samples: what filters that keep a history, and measures of sequences,
// compare between frames.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "frame/frame.h"
#include "sequence/reprojection.h"

namespace ld {

/// The sample that stands for a pixel: of those that are valid the one of the lower median depth, the first
/// of equals; -1 where there is none.
int representative_sample(const Frame& frame, size_t pixel);

/// Turns directions of view space into the world, row by row, so that frames of a moving camera compare;
/// none where the frame does not say where its camera stood.
std::optional<std::array<float, 9>> view_to_world(const FrameInfo& info);

/// Planes [height, width]. Each pixel's surface is that of its representative sample, so that its numbers
/// belong together. kEscapedDepth where that ray escaped or no sample is valid.
struct SurfaceGuides {
  int width = 0, height = 0;
  float depth_scale = 1;
  std::vector<SeenSurface> surface;
  std::vector<float> depth, flow_x, flow_y;
  std::vector<float> flow_z;  // previous depth of the surface less its present one
  bool has_flow = false;      // without, nothing is known of the frame before

  size_t index(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
};

/// What the frame does not hold is the same everywhere: a depth of 1, a normal towards the camera, id 0, no
/// flow along the depth.
SurfaceGuides surface_guides(const Frame& frame);

/// The bilinear lookup in the previous frame for one pixel: the taps that show the same surface, their
/// weights normalised to the sum 1.
struct Reprojection {
  std::array<BilinearTap, 4> taps{};
  bool valid = false;
  /// The pixel of the previous frame that shows the surface, in planes: the heaviest tap, else the first of
  /// the 3x3 around the place; -1: none. At an edge, samples within the pixel hit one surface now, the other
  /// then.
  int64_t seen_at = -1;
};

/// Of every pixel, [height, width]: at its place plus its flow. Neither valid nor seen where the ray escaped,
/// where the place lies outside, where no pixel passes is_same_surface, in a frame without flow, and where
/// the sizes differ.
std::vector<Reprojection> reproject(const SurfaceGuides& now, const SurfaceGuides& before);

}  // namespace ld
