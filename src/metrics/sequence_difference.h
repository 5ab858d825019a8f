// How a picture changes from frame to frame beside how its reference does: one definition for measures and
// for training. Plain arrays; what the networks' library needs are the value and its gradient.
#pragma once

#include <vector>

#include "sequence/surface_guides.h"

namespace ld {

/// For each pixel [height, width] where it was in the frame before, and whether it was seen there.
using Warp = std::vector<Reprojection>;

/// Every pixel was where it is.
Warp identity_warp(int width, int height);

/// W: the bilinear lookup in planes [C, height, width] of the frame before; 0 where the pixel was not seen.
template <class T>
std::vector<T> warped(const std::vector<T>& before, const Warp& warp, int width);

/// What becomes of e = (d_t - W d_(t-1)) - (r_t - W r_(t-1)); b is its second bracket.
enum class TemporalNorm {
  absolute,  // |e|
  squared,   // e^2
  relative,  // |e| / (|b| + kTemporalEpsilon)
};
constexpr double kTemporalEpsilon = 0.01;

/// Two frames that follow one another, planes [C, height, width] of any values: tone-mapped ones for the
/// measures.
template <class T>
struct TemporalPictures {
  const std::vector<T>&now, &before, &reference_now, &reference_before;
};

/// Mean over the channels of the pixels that were seen before; NaN where there is none. An error that stands
/// still does not count: |e| = 0 where d = r + c.
template <class T>
double temporal_error(TemporalNorm norm, const TemporalPictures<T>& pictures, const Warp& warp, int width);

/// Adds `scale` times the gradient of temporal_error with respect to d_t and d_(t-1), planes of their size; 0
/// at the kink of |e|. Nothing where no pixel was seen before.
template <class T>
void add_temporal_gradient(TemporalNorm norm, const TemporalPictures<T>& pictures, const Warp& warp,
                           int width, double scale, std::vector<T>& now, std::vector<T>& before);

}  // namespace ld
