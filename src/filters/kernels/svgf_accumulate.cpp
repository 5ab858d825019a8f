#include "filters/kernels/svgf_accumulate.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filters/kernels/svgf_accumulate.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "filters/kernels/bilinear-inl.h"
#include "filters/kernels/light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

HWY_INLINE V bounded_luminance(D d, const Colour& c) {
  const V most = hn::Set(d, kLargestMoment);
  return hn::Min(hn::Max(luminance(d, c), hn::Neg(most)), most);
}

/// Finds the taps of the pixels at x; returns which lanes have any, and in `searched` which lie in the
/// picture but have none.
HWY_INLINE hn::Mask<D> find_taps(D d, const AccumulateRow& row, int64_t x, BilinearTaps& taps,
                                 hn::Mask<D>& searched) {
  const DI di;
  const float* here = row.surfaces + x;
  const V id = hn::LoadU(d, here + kId * row.pitch);
  const Colour normal = load_colour(d, here + kNormalX * row.pitch, row.pitch);
  const V depth =
      hn::Add(hn::LoadU(d, here + kDepth * row.pitch), hn::LoadU(d, row.flow + 2 * row.pitch + x));
  const V slope =
      hn::Max(hn::Abs(hn::LoadU(d, row.slopes + x)), hn::Abs(hn::LoadU(d, row.slopes + row.pitch + x)));
  const V tolerance = hn::MulAdd(slope, hn::Set(d, row.test.depth_slopes), hn::Set(d, row.test.depth_least));
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0F);
  V px = hn::Add(hn::Iota(d, float(x)), hn::LoadU(d, row.flow + x));
  V py = hn::Add(hn::Set(d, float(row.y)), hn::LoadU(d, row.flow + row.pitch + x));
  // False for NaN, too; then no index leaves the margins.
  const auto near_picture =
      hn::And(hn::And(hn::Gt(px, hn::Set(d, -2.0F)), hn::Lt(px, hn::Set(d, float(row.width + 1)))),
              hn::And(hn::Gt(py, hn::Set(d, -2.0F)), hn::Lt(py, hn::Set(d, float(row.height + 1)))));
  px = hn::IfThenElseZero(near_picture, px);
  py = hn::IfThenElseZero(near_picture, py);
  const V left = hn::Floor(px), top = hn::Floor(py), fx = hn::Sub(px, left), fy = hn::Sub(py, top);
  for (int i = 0; i < 2; ++i) taps.x[i] = hn::ConvertTo(di, hn::Add(left, hn::Set(d, float(i))));
  const V last = hn::Set(d, float(row.height - 1));
  for (int j = 0; j < 2; ++j)
    taps.y[j] = hn::ConvertTo(di, hn::Min(hn::Max(hn::Add(top, hn::Set(d, float(j))), zero), last));
  taps.settle();
  V total = zero;
  for (int j = 0; j < 2; ++j) {
    const V v = hn::Add(top, hn::Set(d, float(j)));
    const auto inside = hn::And(near_picture, hn::And(hn::Ge(v, zero), hn::Le(v, last)));
    for (int i = 0; i < 2; ++i) {
      const auto gathered = [&](int plane)
                                HWY_ATTR { return taps.tap(d, row.surfaces_before, plane, 2 * j + i); };
      const V cosine = dot(normal, {gathered(kNormalX), gathered(kNormalY), gathered(kNormalZ)});
      const auto same = hn::And(hn::And(inside, hn::Eq(gathered(kId), id)),
                                hn::And(hn::Le(hn::Abs(hn::Sub(gathered(kDepth), depth)), tolerance),
                                        hn::Ge(cosine, hn::Set(d, row.test.least_cosine))));
      const V w = hn::Mul(i == 0 ? hn::Sub(one, fx) : fx, j == 0 ? hn::Sub(one, fy) : fy);
      taps.weight[2 * j + i] = hn::IfThenElseZero(same, w);
      total = hn::Add(total, taps.weight[2 * j + i]);
    }
  }
  const auto found = hn::Ge(total, hn::Set(d, kLeastTapWeight));
  searched = hn::And(hn::And(near_picture, hn::Eq(id, id)), hn::Lt(total, hn::Set(d, kLeastTapWeight)));
  const V scale = hn::Div(one, hn::IfThenElse(found, total, one));
  for (V& weight : taps.weight) weight = hn::Mul(weight, scale);
  return found;
}

/// m1 and m2 - m1^2: the latter kept in place of m2, because a difference of nearly equal numbers has no
/// digits left. lerp(m', (Y, Y^2), share).
HWY_INLINE void blend_moments(D d, const BilinearTaps& taps, const PlaneView& before, int plane, V share,
                              V& m1, V& variance) {
  const V old_m1 = taps.mean(d, before, plane), step = hn::Sub(m1, old_m1);
  variance = hn::MulAdd(share, hn::Mul(step, step), taps.variance(d, before, plane, old_m1));
  variance = hn::Mul(hn::Sub(hn::Set(d, 1.0F), share), variance);
  m1 = hn::MulAdd(share, step, old_m1);
}

HWY_INLINE V blend_channel(D d, const BilinearTaps& taps, const AccumulateRow& row, int64_t x, int signal,
                           int channel, V share, V now) {
  V history = taps.mean(d, row.light_before, 4 * signal + channel);
  if (row.bounds != nullptr) {
    const float* bounds = row.bounds + row.pitch * 2 * (3 * signal + channel) + x;
    history = hn::Min(hn::Max(history, hn::LoadU(d, bounds)), hn::LoadU(d, bounds + row.pitch));
  }
  return hn::MulAdd(share, now, hn::Mul(hn::Sub(hn::Set(d, 1.0F), share), history));
}

void bounds_row(const HistoryBoundsRow& row) {
  const D d;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0F), most_s = hn::Set(d, kLargestMoment);
  const int64_t pitch = row.pitch;
  float *const counts = row.columns, *const sums = counts + pitch, *const squares = sums + pitch;
  for (int p = 0; p < row.planes; ++p) {
    // Sums of five rows, margins and all: their ids are NaN.
    for (int64_t x = -lanes(); x < row.width + lanes(); x += lanes()) {
      V count = zero, sum = zero, square = zero;
      for (size_t j = 0; j < 5; ++j) {
        if (row.ids[j] == nullptr) continue;
        const V id = hn::LoadU(d, row.ids[j] + x), signal = hn::LoadU(d, row.signals[j] + p * pitch + x);
        const auto any = hn::Eq(id, id);
        const V s = hn::IfThenElseZero(any, hn::Min(hn::Max(signal, hn::Neg(most_s)), most_s));
        count = hn::Add(count, hn::IfThenElseZero(any, one));
        sum = hn::Add(sum, s);
        square = hn::MulAdd(s, s, square);
      }
      hn::StoreU(count, d, counts + x);
      hn::StoreU(sum, d, sums + x);
      hn::StoreU(square, d, squares + x);
    }
    float* const least = row.bounds + pitch * 2 * p;
    for (int64_t x = 0; x < row.width; x += lanes()) {
      const auto five = [&](const float* a) HWY_ATTR {
        V sum = hn::LoadU(d, a + x);
        for (const int64_t i : {-2, -1, 1, 2}) sum = hn::Add(sum, hn::LoadU(d, a + x + i));
        return sum;
      };
      const V share = hn::Div(one, hn::Max(five(counts), one)), mean = hn::Mul(five(sums), share);
      const V variance = hn::NegMulAdd(mean, mean, hn::Mul(five(squares), share));
      const V reach = hn::Mul(hn::Set(d, row.deviations), hn::Sqrt(hn::Max(variance, zero)));
      const V own = hn::LoadU(d, row.signals[2] + p * pitch + x);
      hn::StoreU(hn::Min(hn::Sub(mean, reach), own), d, least + x);
      hn::StoreU(hn::Max(hn::Add(mean, reach), own), d, least + pitch + x);
    }
  }
}

template <int kSignals, bool kRemembers>
HWY_NOINLINE void accumulate_row(const AccumulateRow& row) {
  const D d;
  const int64_t pitch = row.pitch;
  const V one = hn::Set(d, 1.0F);
  for (int64_t x = 0; x < row.width; x += lanes()) {
    BilinearTaps taps;
    hn::Mask<D> searched, found;
    V length = one, share = one, share_moments = one;
    if (kRemembers) {
      found = find_taps(d, row, x, taps, searched);
      hn::StoreU(hn::IfThenElseZero(searched, one), d, row.missing + x);
      const V before =
          hn::Floor(hn::Add(taps.mean(d, row.moments_before, 2 * kSignals), hn::Set(d, kLengthRounding)));
      length = hn::IfThenElse(found, hn::Min(hn::Add(before, one), hn::Set(d, row.blend.longest)), one);
      share = hn::Max(hn::Div(one, length), hn::Set(d, row.blend.alpha));
      share_moments = hn::Max(hn::Div(one, length), hn::Set(d, row.blend.alpha_moments));
    }
    hn::StoreU(length, d, row.moments + pitch * 2 * kSignals + x);
    for (int s = 0; s < kSignals; ++s) {
      const Colour now = load_colour(d, row.signals + pitch * 3 * s + x, pitch);
      Colour light = now;
      V m1 = bounded_luminance(d, now), variance = hn::Zero(d);
      if (kRemembers) {
        const Colour blended{blend_channel(d, taps, row, x, s, 0, share, now.r),
                             blend_channel(d, taps, row, x, s, 1, share, now.g),
                             blend_channel(d, taps, row, x, s, 2, share, now.b)};
        light = if_then_else(found, blended, now);
        V blended_m1 = m1;
        blend_moments(d, taps, row.moments_before, 2 * s, share_moments, blended_m1, variance);
        m1 = hn::IfThenElse(found, blended_m1, m1);
        variance = hn::IfThenElseZero(found, variance);
      }
      store_colour(d, light, row.light + pitch * 4 * s + x, pitch);
      hn::StoreU(variance, d, row.light + (4 * s + 3) * pitch + x);
      hn::StoreU(m1, d, row.moments + pitch * 2 * s + x);
      hn::StoreU(variance, d, row.moments + (2 * s + 1) * pitch + x);
    }
  }
}

void accumulate_any(const AccumulateRow& row, int signals) {
  if (row.surfaces_before.data != nullptr)
    signals == 1 ? accumulate_row<1, true>(row) : accumulate_row<2, true>(row);
  else
    signals == 1 ? accumulate_row<1, false>(row) : accumulate_row<2, false>(row);
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(accumulate_any);
HWY_EXPORT(bounds_row);

void svgf_accumulate_row(const AccumulateRow& row, int signals) {
  HWY_DYNAMIC_DISPATCH(accumulate_any)(row, signals);
}

void svgf_history_bounds_row(const HistoryBoundsRow& row) {
  HWY_DYNAMIC_DISPATCH(bounds_row)(row);
}

}  // namespace ld
#endif
