// Whether two pixels of neighbouring frames show the same surface: the one definition behind the validity of
// warped pictures, in filters that keep a history as in measures of sequences. After the consistency tests of
// Schied et al., "Spatiotemporal variance-guided filtering", High Performance Graphics 2017, section 4.1.
// Plain numbers, no other header of the project.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace ld {

/// Depth of the surface that a pixel shows, in scene units along the view axis, its unit normal, and a number
/// for its object and material. Where a frame knows no normals or numbers, all have the same.
struct SeenSurface {
  float depth = 0;
  float nx = 0, ny = 0, nz = 1;
  float id = 0;
};

/// Depths may differ by so many times (the depth's slope a pixel + kDepthFloor of the frame's depth scale):
/// the place of a sample within its pixel alone moves the depth by up to the slope.
constexpr float kReprojectionDepth = 10;
constexpr float kReprojectionDepthFloor = 1e-3F;
/// The least cosine between the normals.
constexpr double kReprojectionNormal = 0.9;
/// Bilinear weights of the taps that pass must sum to this, or the pixel has no past.
constexpr float kReprojectionWeight = 0.01F;

/// How far the depth of a tap may be from the expected one. `slope`: depth_slope(); `depth_scale`: the median
/// depth of the frame.
inline float depth_tolerance(float slope, float depth_scale) {
  return kReprojectionDepth * (slope + kReprojectionDepthFloor * depth_scale);
}

/// Whether `before`, in the previous frame, is the surface `now`, whose depth was `expected_depth` then. Both
/// normals in the same space. False for anything that is NaN.
inline bool is_same_surface(const SeenSurface& now, float expected_depth, float tolerance,
                            const SeenSurface& before) {
  return std::abs(before.depth - expected_depth) <= tolerance && before.id == now.id &&
         now.nx * before.nx + now.ny * before.ny + now.nz * before.nz >=
             static_cast<float>(kReprojectionNormal);
}

/// The larger of |dz/dx| and |dz/dy| at a pixel of a plane, in scene units a pixel: one-sided differences, in
/// each direction the smaller of the two, so that an edge beside the pixel does not count. Neighbours at or
/// beyond `escaped` are left out; 0 where there is none.
inline float depth_slope(const float* depth, int width, int height, int x, int y, float escaped) {
  const auto at = [&](int i, int j) {
    return depth[static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i)];
  };
  const float centre = at(x, y);
  const auto smaller = [&](int dx, int dy) {
    float least = -1;
    for (const int side : {-1, 1}) {
      const int i = x + side * dx, j = y + side * dy;
      if (i < 0 || j < 0 || i >= width || j >= height || !(at(i, j) < escaped)) continue;
      const float difference = std::abs(at(i, j) - centre);
      if (least < 0 || difference < least) least = difference;
    }
    return std::max(least, 0.0F);
  };
  return std::max(smaller(1, 0), smaller(0, 1));
}

/// One of the pixels around a place, with its bilinear weight.
struct BilinearTap {
  int x = 0, y = 0;
  float weight = 0;  // 0: outside of the picture
};

/// The four pixels around the place (x, y), whole numbers being the middles of pixels. All weights are 0 for
/// a place outside of the picture, infinite or NaN.
inline std::array<BilinearTap, 4> bilinear_taps(float x, float y, int width, int height) {
  std::array<BilinearTap, 4> taps{};
  if (!(x > -1 && y > -1 && x < static_cast<float>(width) && y < static_cast<float>(height))) return taps;
  const float left = std::floor(x), top = std::floor(y), fx = x - left, fy = y - top;
  for (int k = 0; k < 4; ++k) {
    const int i = static_cast<int>(left) + k % 2, j = static_cast<int>(top) + k / 2;
    const bool inside = i >= 0 && j >= 0 && i < width && j < height;
    if (inside)
      taps[static_cast<size_t>(k)] = {i, j, (k % 2 == 0 ? 1 - fx : fx) * (k / 2 == 0 ? 1 - fy : fy)};
  }
  return taps;
}

}  // namespace ld
