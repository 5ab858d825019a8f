// Spatiotemporal variance-guided filtering (Schied et al. 2017) on plain planes: a function for each pass.
// Signals have three planes each (1 or 2 signals); `light` has four: colour and variance.
#pragma once

#include "filters/kernels/surfaces.h"
#include "filters/settings.h"

namespace ld {

/// All that one frame leaves for the next. Empty before the first: that has no history.
struct SvgfState {
  Surfaces surfaces;
  RowPlanes light;
  RowPlanes
      moments;  // of each signal's luminance, m1 and m2 - m1^2; last, the length of the history in frames

  bool empty() const { return moments.width() == 0; }
  const float* length_row(int64_t y) const { return moments.row(y, moments.planes() - 1); }
};

/// Memory that is kept between frames for its own sake.
struct SvgfMemory {
  RowPlanes slopes, light[2], moments;
};

/// Throws UsageError for settings that contradict one another.
void check_settings(const SvgfSettings& settings);

/// dz/dx and dz/dy: of the differences to both neighbours that have the pixel's surface the smaller one, 0
/// where neither has.
void depth_slopes(const Surfaces& surfaces, RowPlanes& slopes, int threads);

/// Temporal accumulation. The history at p' = p + flow is the bilinear mean of the pixels of the previous
/// frame that show p's surface:
///   id' = id,  |z' - (z + flow_z)| <= history_depth (max |slope| + 0.01 unit),  n . n' >= history_normal;
/// where their weights sum to less than 0.01, the plain mean of such pixels among the 3x3 around p'. Then
///   L = min(L' + 1, longest_history) (L' rounded down, of the 3x3 the smallest), or 1 without a history,
///   c = lerp(c', S, max(alpha, 1 / L)),  m = lerp(m', (Y, Y^2), max(alpha_moments, 1 / L)).
/// The variance in `light` is that of the moments.
void accumulate(const Surfaces& surfaces, const RowPlanes& slopes, const RowPlanes& signals,
                const SvgfState& previous, const SvgfSettings& settings, RowPlanes& light, RowPlanes& moments,
                int threads);

/// Where the history is short, colour and variance become those of the neighbourhood
/// (kernels/svgf_level.h). `spare` is memory of the same size.
void estimate_variance(const Surfaces& surfaces, const RowPlanes& slopes, const RowPlanes& moments,
                       RowPlanes& light, RowPlanes& spare, const SvgfSettings& settings, int threads);

/// One à-trous level, guided by the variance, which it filters, too (kernels/svgf_level.h).
void svgf_level(const Surfaces& surfaces, const RowPlanes& slopes, const RowPlanes& in, RowPlanes& out,
                int64_t level, const SvgfSettings& settings, int threads);

/// All of it for one frame; with levels = 0, the accumulated light. `surfaces` goes into the state and what
/// comes back is to be filled anew. The result, four planes a signal, lies in `state` or `memory` until the
/// next call. A state of another size counts as empty.
const RowPlanes& svgf(Surfaces& surfaces, const RowPlanes& signals, SvgfState& state, SvgfMemory& memory,
                      const SvgfSettings& settings, int threads);

}  // namespace ld
