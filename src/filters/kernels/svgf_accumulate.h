// One row of the temporal accumulation of Schied et al. 2017.
#pragma once

#include <array>

#include "filters/kernels/plane_view.h"

namespace ld {

/// Which pixels of the previous frame show the surface of a pixel: id' = id, n . n' >= least_cosine,
/// |z' - (z + flow_z)| <= depth_slopes max |slope| + depth_least.
struct HistoryTest {
  float depth_slopes = 10, depth_least = 0, least_cosine = 0.9F;
};

/// The shares of the new frame are at least `alpha`; squares of luminances beyond kLargestMoment would not be
/// finite.
struct HistoryBlend {
  float alpha = 0.2F, alpha_moments = 0.2F, longest = 32;
};
constexpr float kLargestMoment = 1e18F;

/// Below so much bilinear weight the neighbourhood is searched.
constexpr float kLeastTapWeight = 0.01F;
/// The bilinear weights of equal lengths add up to 1 but for rounding, which must not cost a frame.
constexpr float kLengthRounding = 1e-3F;

struct AccumulateRow {
  int64_t width = 0, height = 0, y = 0, pitch = 0;
  const float *surfaces = nullptr, *flow = nullptr, *slopes = nullptr, *signals = nullptr;  // of the row
  PlaneView surfaces_before, light_before, moments_before;  // null where nothing is remembered
  const float* bounds =
      nullptr;  // least and most history, a pair of planes for each of the signals' planes; or null
  float *light = nullptr, *moments = nullptr;
  float* missing = nullptr;  // set to 1 where no bilinear tap will do, else 0
  HistoryTest test;
  HistoryBlend blend;
};

/// Least and most history of the pixels of a row: mean +- deviations of the pixels that have a surface among
/// the 5x5 around each, a pair of planes in `bounds` for each plane of the signals. The pixel's own value is
/// always within, so that steady light of a small surface before a brighter one stays.
struct HistoryBoundsRow {
  int64_t width = 0, pitch = 0;
  int planes = 0;
  std::array<const float*, 5> ids{}, signals{};  // rows y - 2 to y + 2, null outside
  float deviations = 0.25F;
  float *columns = nullptr, *bounds = nullptr;  // three planes of a row for the work; the result
};
void svgf_history_bounds_row(const HistoryBoundsRow& row);

/// The history of each pixel at p' = p + flow from its bilinear taps, blended with the new frame
/// (filters/svgf.h, accumulate()). Pixels without one start anew. The fourth plane of each signal's light is
/// the temporal variance, m2 - m1^2.
void svgf_accumulate_row(const AccumulateRow& row, int signals);

}  // namespace ld
