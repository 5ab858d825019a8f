// The edge-avoiding à-trous wavelet filter (Dammertz et al. 2010, "Edge-Avoiding À-Trous Wavelet Transform
// for fast Global Illumination Filtering") on plain planes.
#pragma once

#include "filters/kernels/surfaces.h"
#include "filters/settings.h"

namespace ld {

/// One level: `in` and `out` have three planes for each signal (1 or 2) and must differ. The settings'
/// sigmas, which may be infinite here; with `narrow`, sigma_light / 4^level and |n_p - n_q|^2 / 4^level.
void eaw_level(const Surfaces& surfaces, const RowPlanes& in, RowPlanes& out, int64_t level,
               const EawSettings& settings, int threads);

/// All levels, from 0 on: `signals` goes in and out; `spare` is memory of the same size. Support of L levels:
/// 4 (2^L - 1) + 1 pixels.
void eaw(const Surfaces& surfaces, RowPlanes& signals, RowPlanes& spare, const EawSettings& settings,
         int threads);

}  // namespace ld
