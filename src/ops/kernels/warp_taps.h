// Where a pixel looks in the previous frame, and which of the pixels there may be what it shows. The one
// definition behind warp() of tensors (ops/warp.h) and the runtime's.
#pragma once

#include <cmath>
#include <cstdint>

namespace ld {

/// Of the taps that count; less is a corner of a pixel.
constexpr double kLeastWarpWeight = 0.01;

/// What networks know of the surface that a pixel shows: its encoded depth e = d / (d + scale), 1 where the
/// ray escaped, and its normal in view space. Zeros where a network does not read them.
template <class T>
struct GuideSurface {
  T depth = 0, nx = 0, ny = 0, nz = 0;
};

/// The depths of one surface in two frames differ by at most this factor, their normals by at most 60
/// degrees. That is coarser than what sequence/reprojection.h asks for, because encoded guides know neither
/// the camera nor the frame's depth scale: it rejects what no usual movement between two frames explains.
constexpr double kGuideDepthRatio = 1.25, kGuideNormal = 0.5;

/// Written so that zeros on both sides, and escaped rays on both, are alike; false for anything that is NaN.
template <class T>
bool may_be_same_surface(const GuideSurface<T>& a, const GuideSurface<T>& b) {
  const T ratio = static_cast<T>(kGuideDepthRatio);
  const T a_deeper = a.depth * (1 - b.depth), b_deeper = b.depth * (1 - a.depth);
  const T cosine = a.nx * b.nx + a.ny * b.ny + a.nz * b.nz;
  const T lengths =
      std::sqrt(a.nx * a.nx + a.ny * a.ny + a.nz * a.nz) * std::sqrt(b.nx * b.nx + b.ny * b.ny + b.nz * b.nz);
  return a_deeper <= ratio * b_deeper && b_deeper <= ratio * a_deeper &&
         cosine >= static_cast<T>(kGuideNormal) * lengths;
}

/// The 2x2 pixels around a place, of which some count; weights of the others are 0, those of all sum to 1.
template <class T>
struct WarpTaps {
  int64_t x = 0, y = 0;  // of the upper left one, from -1
  T weights[4] = {0, 0, 0, 0};
  bool valid = false;

  int64_t column(int i) const { return x + i % 2; }
  int64_t row(int i) const { return y + i / 2; }
};

/// Around (x, y), whole numbers being the middles of pixels. `counts(column, row)` says of each pixel of the
/// previous frame whether it does. None are valid outside of the picture, and where weights sum to less than
/// kLeastWarpWeight.
template <class T, class Counts>
WarpTaps<T> warp_taps(T x, T y, int64_t width, int64_t height, const Counts& counts) {
  WarpTaps<T> at;
  // Written so that NaN is outside too, and no number is converted that an integer cannot hold.
  if (!(x > -1 && x < static_cast<T>(width) && y > -1 && y < static_cast<T>(height))) return at;
  const T left = std::floor(x), top = std::floor(y), fx = x - left, fy = y - top;
  at.x = static_cast<int64_t>(left);
  at.y = static_cast<int64_t>(top);
  const T shares[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  T sum = 0;
  for (int i = 0; i < 4; ++i) {
    const int64_t column = at.column(i), row = at.row(i);
    if (column < 0 || column >= width || row < 0 || row >= height || !counts(column, row)) continue;
    at.weights[i] = shares[i];
    sum += shares[i];
  }
  at.valid = sum >= static_cast<T>(kLeastWarpWeight);
  for (T& weight : at.weights) weight = at.valid ? weight / sum : 0;
  return at;
}

}  // namespace ld
