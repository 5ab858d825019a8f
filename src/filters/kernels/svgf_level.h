// One row of the spatial passes of Schied et al. 2017.
#pragma once

#include <array>
#include <cstdint>

#include "filters/kernels/level_row.h"

namespace ld {

/// What w_n and w_z compare surfaces with:
///   w_n = max(0, n_p . n_q)^(2^normal_squarings)
///   w_z = exp(-|z_p - z_q| / (sigma_depth |grad z(p) . (p - q)| + depth_tolerance z_p)),
/// or, `isotropic`, with max(|dz/dx|, |dz/dy|) |p - q| for the product with the gradient.
struct SurfaceWeights {
  int64_t normal_squarings = 7;
  float sigma_depth = 1, depth_tolerance = 1e-3F;
  bool isotropic = false;
};

/// `slopes`: the row's dz/dx and dz/dy.
struct SvgfLevelRow {
  LevelRow level;
  const float* slopes = nullptr;
  std::array<const float*, 3> above_below{};  // rows y - 1 to y + 1 of `in`, null outside
  SurfaceWeights surface;
  float sigma_light = 4;
  bool moments = false;
};

/// c'(p) = sum_q h w c(q) / sum_q h w,  v'(p) = sum_q h^2 w^2 v(q) / (sum_q h w)^2, that of independent taps,
/// or, `moments`, of one distribution: m2' - m1'^2 of the moments m = (Y, v + Y^2), filtered as the colour
/// is;
///   w = w_n w_z w_l,  w_l = exp(-|Y_p - Y_q| / (sigma_light sqrt(g(p)) + 1e-10)),
/// g the variance under a 3x3 Gaussian; for `signals` (1 or 2) of four planes each: colour and variance.
void svgf_level_row(const SvgfLevelRow& row, int signals);

/// Where the history is shorter than four frames, from the 7x7 pixels around p with w = w_n w_z:
///   c'(p) = sum_q w c(q) / sum_q w,  v'(p) = 4 / L(p) (m2 - m1^2), m the weighted means of moments.
/// `moments` are m1 and m2 - m1^2. A pixel that hardly any other resembles (of a wire, of a sphere of a few
/// pixels) would show the noise of its own sample, which mostly is black: what its weights lack of
/// kFewestNeighbours is shared out evenly among the pixels with its id. `out` gets vectors that hold such a
/// pixel only; in the others nothing changes.
constexpr int kVarianceRadius = 3;
constexpr float kShortHistory = 4, kFewestNeighbours = 4;
struct SvgfVarianceRow {
  int64_t width = 0, pitch = 0;
  std::array<const float*, 2 * kVarianceRadius + 1> surfaces{}, light{}, moments{};  // null outside
  const float* slopes = nullptr;
  float* out = nullptr;
  SurfaceWeights surface;
};
void svgf_variance_row(const SvgfVarianceRow& row, int signals);

}  // namespace ld
