// The à-trous cascade of both filters: kernels and rows of one level.
#pragma once

#include <string>

#include "filters/kernels/level_row.h"
#include "filters/kernels/row_planes.h"
#include "filters/kernels/surfaces.h"
#include "runtime/parallel.h"

namespace ld {

/// The 1-D kernel at distance 0, 1, 2: "b3", the cubic B-spline (6, 4, 1) / 16, or "gauss", deviation 1.
std::array<float, 3> a_trous_taps(const std::string& kernel);

/// Row y of level k (stride 2^k).
LevelRow level_row(const Surfaces& surfaces, const RowPlanes& in, RowPlanes& out, int64_t y, int64_t level,
                   const std::array<float, 3>& taps);

}  // namespace ld
