#include "filters/kernels/svgf_level.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filters/kernels/svgf_level.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "filters/kernels/light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

/// The surfaces of a vector of pixels, and what taps are compared with.
template <bool kIsotropic>
struct SurfaceAt {
  SurfaceAt(D d, const SurfaceWeights& w, const float* surface, const float* slopes, int64_t plane_pitch)
      : pitch(plane_pitch), squarings(w.normal_squarings) {
    normal = load_colour(d, surface + kNormalX * pitch, pitch);
    depth = hn::LoadU(d, surface + kDepth * pitch);
    // Never 0, so that equal depths give 0 / something.
    const V log_2 = hn::Set(d, 1 / kLog2E);
    tolerance = hn::Mul(hn::MulAdd(depth, hn::Set(d, w.depth_tolerance), hn::Set(d, 1e-30F)), log_2);
    const V sigma = hn::Mul(hn::Set(d, w.sigma_depth), log_2);
    slope_x = hn::Mul(sigma, hn::LoadU(d, slopes));
    slope_y = hn::Mul(sigma, hn::LoadU(d, slopes + pitch));
    if (kIsotropic) slope_x = hn::Max(hn::Abs(slope_x), hn::Abs(slope_y));
  }

  /// w_n
  HWY_INLINE V normal_weight(D d, const float* there) const {
    V w = hn::Max(dot(normal, load_colour(d, there + kNormalX * pitch, pitch)), hn::Zero(d));
    if (squarings == 7) {  // the default, without a loop
      for (int i = 0; i < 7; ++i) w = hn::Mul(w, w);
      return w;
    }
    for (int64_t i = 0; i < squarings; ++i) w = hn::Mul(w, w);
    return w;
  }

  /// log2 w_z of the tap (dx, dy) pixels away.
  HWY_INLINE V depth_exponent(D d, const float* there, float dx, float dy) const {
    if (kIsotropic) return hn::Mul(depth_difference(d, there), precision_at(d, std::sqrt(dx * dx + dy * dy)));
    const V explained = hn::Abs(hn::MulAdd(slope_x, hn::Set(d, dx), hn::Mul(slope_y, hn::Set(d, dy))));
    return hn::Neg(hn::Div(depth_difference(d, there), hn::Add(explained, tolerance)));
  }
  HWY_INLINE V depth_difference(D d, const float* there) const {
    return hn::Abs(hn::Sub(depth, hn::LoadU(d, there + kDepth * pitch)));
  }
  /// Of isotropic slopes: what the difference is multiplied with at that distance.
  HWY_INLINE V precision_at(D d, float distance) const {
    return hn::Div(hn::Set(d, -1.0F), hn::MulAdd(slope_x, hn::Set(d, distance), tolerance));
  }

  int64_t pitch, squarings;
  Colour normal;
  V depth, tolerance, slope_x, slope_y;
};

/// The variance under a 3x3 Gaussian; beyond the border are zeros that count for nothing.
HWY_INLINE V blurred_variance(D d, const SvgfLevelRow& row, int64_t x, int plane) {
  V sum = hn::Zero(d);
  float rows = 0;
  for (int j = 0; j < 3; ++j) {
    if (row.above_below[size_t(j)] == nullptr) continue;
    const float* v = row.above_below[size_t(j)] + plane * row.level.pitch + x;
    const V across =
        hn::MulAdd(hn::LoadU(d, v), hn::Set(d, 2.0F), hn::Add(hn::LoadU(d, v - 1), hn::LoadU(d, v + 1)));
    const float h = j == 1 ? 2.0F : 1.0F;
    sum = hn::MulAdd(across, hn::Set(d, h), sum);
    rows += h;
  }
  const V at = hn::Iota(d, float(x)), one = hn::Set(d, 1.0F);
  const V columns = hn::Add(
      hn::Set(d, 2.0F), hn::Add(hn::IfThenElseZero(hn::Gt(at, hn::Zero(d)), one),
                                hn::IfThenElseZero(hn::Lt(at, hn::Set(d, float(row.level.width - 1))), one)));
  return hn::Div(sum, hn::Mul(columns, hn::Set(d, rows)));
}

template <int kSignals, bool kIsotropic, bool kMoments>
HWY_NOINLINE void level_row(const SvgfLevelRow& row) {
  const D d;
  const LevelRow& level = row.level;
  const int64_t pitch = level.pitch;
  const V centre = hn::Set(d, level.h_centre);
  for (int64_t x = level.first; x < level.end; x += lanes()) {
    fetch_ahead(level, x);
    const SurfaceAt<kIsotropic> here(d, row.surface, level.surfaces + x, row.slopes + x, pitch);
    V reach[kTapDistances];
    if (kIsotropic)
      for (size_t k = 0; k < kTapDistances; ++k) reach[k] = here.precision_at(d, level.distances[k]);
    Colour c_p[kSignals], sum[kSignals];
    V v_p[kSignals], y_p[kSignals], precision[kSignals], total[kSignals], sum_v[kSignals], sum_y[kSignals];
    for (int s = 0; s < kSignals; ++s) {
      const float* in = level.in + pitch * 4 * s + x;
      c_p[s] = load_colour(d, in, pitch);
      v_p[s] = hn::LoadU(d, in + 3 * pitch);
      y_p[s] = luminance(d, c_p[s]);
      const V deviation = hn::Sqrt(blurred_variance(d, row, x, 4 * s + 3));
      precision[s] = hn::Div(hn::Set(d, -kLog2E),
                             hn::MulAdd(deviation, hn::Set(d, row.sigma_light), hn::Set(d, 1e-10F)));
      sum[s] = scaled(c_p[s], centre);
      sum_v[s] = hn::Mul(v_p[s], kMoments ? centre : hn::Mul(centre, centre));
      sum_y[s] = hn::Zero(d);
      total[s] = centre;
    }
    for_each_tap(d, level, x, [&](const LevelTap& tap, auto same) HWY_ATTR {
      const float* there = tap.surfaces + x;
      const V z = kIsotropic ? hn::Mul(here.depth_difference(d, there), reach[tap.distance])
                             : here.depth_exponent(d, there, tap.dx, tap.dy);
      const V h = hn::Mul(hn::IfThenElseZero(same, hn::Set(d, tap.h)), here.normal_weight(d, there));
      for (int s = 0; s < kSignals; ++s) {
        const float* in = tap.in + pitch * 4 * s + x;
        const Colour c_q = load_colour(d, in, pitch);
        const V more = hn::Sub(luminance(d, c_q), y_p[s]);
        const V hw = hn::Mul(h, power_of_two(d, hn::MulAdd(hn::Abs(more), precision[s], z)));
        total[s] = hn::Add(total[s], hw);
        add_weighted(sum[s], hw, c_q);
        if (kMoments) {
          sum_y[s] = hn::MulAdd(hw, more, sum_y[s]);
          sum_v[s] = hn::MulAdd(hw, hn::MulAdd(more, more, hn::LoadU(d, in + 3 * pitch)), sum_v[s]);
        } else {
          sum_v[s] = hn::MulAdd(hn::Mul(hw, hw), hn::LoadU(d, in + 3 * pitch), sum_v[s]);
        }
      }
    });
    const V surface = hn::LoadU(d, level.surfaces + kId * pitch + x);
    const auto any = hn::Eq(surface, surface);  // NaN where there is none
    for (int s = 0; s < kSignals; ++s) {
      const V share = hn::Div(hn::Set(d, 1.0F), total[s]);
      float* out = level.out + pitch * 4 * s + x;
      store_colour(d, if_then_else(any, scaled(sum[s], share), c_p[s]), out, pitch);
      V v = hn::Mul(sum_v[s], share);
      if (kMoments) {
        const V mean = hn::Mul(sum_y[s], share);
        v = hn::Max(hn::NegMulAdd(mean, mean, v), hn::Zero(d));
      } else {
        v = hn::Mul(v, share);
      }
      hn::StoreU(hn::IfThenElse(any, v, v_p[s]), d, out + 3 * pitch);
    }
  }
}

template <int kSignals, bool kIsotropic>
void level_with(const SvgfLevelRow& row) {
  row.moments ? level_row<kSignals, kIsotropic, true>(row) : level_row<kSignals, kIsotropic, false>(row);
}

void level_any(const SvgfLevelRow& row, int signals) {
  if (row.surface.isotropic)
    signals == 1 ? level_with<1, true>(row) : level_with<2, true>(row);
  else
    signals == 1 ? level_with<1, false>(row) : level_with<2, false>(row);
}

/// Sums over the neighbourhood of a vector of pixels, moments about m1(p): no digits are lost when all are
/// alike.
struct NeighbourhoodSums {
  Colour colour;
  V m1, m2, total;

  explicit NeighbourhoodSums(D d)
      : colour{hn::Zero(d), hn::Zero(d), hn::Zero(d)}, m1(hn::Zero(d)), m2(m1), total(m1) {}

  /// weight(same, there, i, j) for the taps of which some lane has the pixel's surface.
  template <class Weight>
  HWY_INLINE void add_all(D d, const SvgfVarianceRow& row, int64_t x, int signal, const Weight& weight) {
    const int64_t pitch = row.pitch;
    const V surface = hn::LoadU(d, row.surfaces[kVarianceRadius] + kId * pitch + x),
            m1_p = hn::LoadU(d, row.moments[kVarianceRadius] + pitch * 2 * signal + x);
    for (int j = -kVarianceRadius; j <= kVarianceRadius; ++j) {
      const auto at = size_t(j + kVarianceRadius);
      if (row.surfaces[at] == nullptr) continue;
      for (int i = -kVarianceRadius; i <= kVarianceRadius; ++i) {
        const int64_t q = x + i;
        const float* const there = row.surfaces[at] + q;
        const auto same = hn::Eq(surface, hn::LoadU(d, there + kId * pitch));
        if (hn::AllFalse(d, same)) continue;
        const V w = weight(same, there, i, j);
        const float* const moments = row.moments[at] + pitch * 2 * signal + q;
        total = hn::Add(total, w);
        add_weighted(colour, w, load_colour(d, row.light[at] + pitch * 4 * signal + q, pitch));
        const V difference = hn::Sub(hn::LoadU(d, moments), m1_p);
        m1 = hn::MulAdd(w, difference, m1);
        m2 = hn::MulAdd(w, hn::MulAdd(difference, difference, hn::LoadU(d, moments + pitch)), m2);
      }
    }
  }

  HWY_INLINE void add(V share, const NeighbourhoodSums& other) {
    add_weighted(colour, share, other.colour);
    m1 = hn::MulAdd(share, other.m1, m1);
    m2 = hn::MulAdd(share, other.m2, m2);
    total = hn::MulAdd(share, other.total, total);
  }
};

template <bool kIsotropic>
HWY_NOINLINE void variance_row(const SvgfVarianceRow& row, int signals) {
  const D d;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0F), fewest = hn::Set(d, kFewestNeighbours);
  const int64_t pitch = row.pitch;
  const float* const here_surface = row.surfaces[kVarianceRadius];
  for (int64_t x = 0; x < row.width; x += lanes()) {
    const V surface = hn::LoadU(d, here_surface + kId * pitch + x);
    const V length = hn::LoadU(d, row.moments[kVarianceRadius] + pitch * 2 * signals + x);
    const auto is_short = hn::And(hn::Lt(length, hn::Set(d, kShortHistory)), hn::Eq(surface, surface));
    if (hn::AllFalse(d, is_short)) continue;
    const SurfaceAt<kIsotropic> here(d, row.surface, here_surface + x, row.slopes + x, pitch);
    for (int s = 0; s < signals; ++s) {
      const float* const in = row.light[kVarianceRadius] + pitch * 4 * s + x;
      NeighbourhoodSums sums(d);
      sums.add_all(d, row, x, s, [&](auto same, const float* there, int i, int j) HWY_ATTR {
        if (i == 0 && j == 0) return hn::IfThenElseZero(same, one);
        return hn::IfThenElseZero(
            same, hn::Mul(here.normal_weight(d, there),
                          power_of_two(d, here.depth_exponent(d, there, float(i), float(j)))));
      });
      if (!hn::AllTrue(d, hn::Ge(sums.total, fewest))) {
        NeighbourhoodSums all(d);
        all.add_all(d, row, x, s, [&](auto same, const float* /*there*/, int /*i*/, int /*j*/) HWY_ATTR {
          return hn::IfThenElseZero(same, one);
        });
        const V lacking = hn::Max(hn::Sub(fewest, sums.total), zero);
        sums.add(hn::Div(lacking, hn::Max(all.total, one)), all);
      }
      const V share = hn::Div(one, hn::Max(sums.total, one));
      // A length of 0 is that of the margin.
      const V boost = hn::Div(hn::Set(d, kShortHistory), hn::Max(length, one));
      const V m1 = hn::Mul(sums.m1, share), m2 = hn::Mul(sums.m2, share);
      const V spatial = hn::Mul(hn::Max(hn::NegMulAdd(m1, m1, m2), zero), boost);
      float* const out = row.out + pitch * 4 * s + x;
      store_colour(d, if_then_else(is_short, scaled(sums.colour, share), load_colour(d, in, pitch)), out,
                   pitch);
      hn::StoreU(hn::IfThenElse(is_short, spatial, hn::LoadU(d, in + 3 * pitch)), d, out + 3 * pitch);
    }
  }
}

void variance_any(const SvgfVarianceRow& row, int signals) {
  row.surface.isotropic ? variance_row<true>(row, signals) : variance_row<false>(row, signals);
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(level_any);
HWY_EXPORT(variance_any);

void svgf_level_row(const SvgfLevelRow& row, int signals) {
  HWY_DYNAMIC_DISPATCH(level_any)(row, signals);
}

void svgf_variance_row(const SvgfVarianceRow& row, int signals) {
  HWY_DYNAMIC_DISPATCH(variance_any)(row, signals);
}

}  // namespace ld
#endif
