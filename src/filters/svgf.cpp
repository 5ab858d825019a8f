#include "filters/svgf.h"

#include <cmath>
#include <utility>

#include "core/error.h"
#include "filters/kernels/svgf_level.h"
#include "filters/levels.h"
#include "runtime/denormals.h"

namespace ld {
namespace {

SurfaceWeights surface_weights(const SvgfSettings& settings) {
  SurfaceWeights weights;
  weights.normal_squarings = settings.normal_squarings;
  weights.sigma_depth = float(settings.sigma_depth);
  weights.depth_tolerance = float(settings.depth_tolerance);
  weights.isotropic = settings.slope == "isotropic";
  return weights;
}

/// Of two differences that may be missing the smaller one.
float smaller_slope(bool has_before, float before, bool has_after, float after) {
  if (has_before && has_after) return std::abs(before) < std::abs(after) ? before : after;
  return has_before ? before : has_after ? after : 0.0F;
}

}  // namespace

void check_settings(const SvgfSettings& settings) {
  if (settings.levels == 0 && settings.feedback >= 0)
    fail_usage("levels=0 leaves no level whose output could be fed back, but feedback is {}; expected -1",
               settings.feedback);
  if (settings.feedback >= settings.levels)
    fail_usage("feedback is {}, but the last of {} levels is {}; expected -1 to {}", settings.feedback,
               settings.levels, settings.levels - 1, settings.levels - 1);
}

void depth_slopes(const Surfaces& surfaces, RowPlanes& slopes, int threads) {
  const int width = surfaces.width(), height = surfaces.height();
  resize(slopes, width, height, 2);
  parallel_for(threads, height, [&](int64_t y, int) {
    const float *id = surfaces.of.row(y, kId), *z = surfaces.of.row(y, kDepth);
    const int64_t up = std::max<int64_t>(y - 1, 0), down = std::min<int64_t>(y + 1, height - 1);
    const float *id_up = surfaces.of.row(up, kId), *z_up = surfaces.of.row(up, kDepth);
    const float *id_down = surfaces.of.row(down, kId), *z_down = surfaces.of.row(down, kDepth);
    float *dx = slopes.row(y, 0), *dy = slopes.row(y, 1);
    for (int x = 0; x < width; ++x) {  // the margin's id is NaN and equals none
      dx[x] = smaller_slope(id[x - 1] == id[x], z[x] - z[x - 1], id[x + 1] == id[x], z[x + 1] - z[x]);
      dy[x] = smaller_slope(up < y && id_up[x] == id[x], z[x] - z_up[x], down > y && id_down[x] == id[x],
                            z_down[x] - z[x]);
    }
  });
}

void estimate_variance(const Surfaces& surfaces, const RowPlanes& slopes, const RowPlanes& moments,
                       RowPlanes& light, RowPlanes& spare, const SvgfSettings& settings, int threads) {
  const int width = light.width(), height = light.height(), planes = light.planes();
  resize(spare, width, height, planes);
  const SurfaceWeights weights = surface_weights(settings);
  parallel_for(threads, height, [&](int64_t y, int) {
    SvgfVarianceRow row;
    row.width = width;
    row.pitch = light.pitch();
    row.surface = weights;
    for (size_t j = 0; j < row.surfaces.size(); ++j) {
      const int64_t at = y + int64_t(j) - kVarianceRadius;
      if (at < 0 || at >= height) continue;
      row.surfaces[j] = surfaces.of.row(at);
      row.light[j] = light.row(at);
      row.moments[j] = moments.row(at);
    }
    row.slopes = slopes.row(y);
    row.out = spare.row(y);
    svgf_variance_row(row, planes / 4);
  });
  // When no neighbourhood needs them any more.
  parallel_for(threads, height, [&](int64_t y, int) {
    const float *const length = moments.row(y, moments.planes() - 1), *const id = surfaces.of.row(y, kId);
    for (int x = 0; x < width; ++x)
      if (length[x] < kShortHistory && id[x] == id[x])
        for (int p = 0; p < planes; ++p) light.row(y, p)[x] = spare.row(y, p)[x];
  });
}

void svgf_level(const Surfaces& surfaces, const RowPlanes& slopes, const RowPlanes& in, RowPlanes& out,
                int64_t level, const SvgfSettings& settings, int threads) {
  resize(out, in.width(), in.height(), in.planes());
  const std::array<float, 3> taps = a_trous_taps("b3");
  const SurfaceWeights weights = surface_weights(settings);
  for_each_piece(threads, in.width(), in.height(), level, [&](const LevelPiece& piece) {
    const int64_t y = piece.y;
    SvgfLevelRow row;
    row.level = level_row(surfaces, in, out, piece, level, taps);
    row.slopes = slopes.row(y);
    for (int64_t j = 0; j < 3; ++j)
      if (y + j >= 1 && y + j <= in.height()) row.above_below[size_t(j)] = in.row(y + j - 1);
    row.surface = weights;
    row.sigma_light = float(settings.sigma_light);
    row.moments = settings.variance == "moments";
    svgf_level_row(row, in.planes() / 4);
  });
}

const RowPlanes& svgf(Surfaces& surfaces, const RowPlanes& signals, SvgfState& state, SvgfMemory& memory,
                      const SvgfSettings& settings, int threads) {
  check_settings(settings);
  const FlushedDenormals flushed(threads);
  const int width = surfaces.width(), height = surfaces.height(), planes = signals.planes() / 3 * 4;
  if (!state.light.is(width, height, planes)) state = {};

  depth_slopes(surfaces, memory.slopes, threads);
  accumulate(surfaces, memory.slopes, signals, state, settings, memory.light[0], memory.moments, threads);
  if (settings.levels > 0)
    estimate_variance(surfaces, memory.slopes, memory.moments, memory.light[0], memory.light[1], settings,
                      threads);
  std::swap(state.surfaces, surfaces);
  std::swap(state.moments, memory.moments);

  resize(state.light, width, height, planes);
  RowPlanes* in = &memory.light[0];
  if (settings.feedback < 0) {
    std::swap(state.light, *in);
    in = &state.light;
  }
  for (int64_t level = 0; level < settings.levels; ++level) {
    RowPlanes* const out =
        level == settings.feedback ? &state.light : &memory.light[in == &memory.light[0] ? 1 : 0];
    svgf_level(state.surfaces, memory.slopes, *in, *out, level, settings, threads);
    in = out;
  }
  return *in;
}

}  // namespace ld
