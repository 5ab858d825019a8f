#include "filters/kernels/eaw_level.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filters/kernels/eaw_level.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "filters/kernels/light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

template <int kSignals, bool kLuminance, bool kDepthOnly>
HWY_NOINLINE void eaw_row(const LevelRow& row, const EawPrecision& precision) {
  const D d;
  const int64_t pitch = row.pitch;
  const V light = hn::Set(d, -kLog2E * precision.light), normal = hn::Set(d, -kLog2E * precision.normal),
          place = hn::Set(d, -kLog2E * precision.place);
  const V largest = hn::Set(d, std::numeric_limits<float>::max());  // times a precision of 0 it is 0
  for (int64_t x = row.first; x < row.end; x += lanes()) {
    fetch_ahead(row, x);
    const float* here = row.surfaces + x;
    const Colour n_p = load_colour(d, here + kNormalX * pitch, pitch);
    const Colour x_p = load_colour(d, here + kPositionX * pitch, pitch);
    const V z_p = hn::LoadU(d, here + kDepth * pitch);
    const V centre = hn::Set(d, row.h_centre);
    Colour c_p[kSignals], sum[kSignals];
    V y_p[kSignals], total[kSignals];
    for (int s = 0; s < kSignals; ++s) {
      c_p[s] = load_colour(d, row.in + pitch * 3 * s + x, pitch);
      y_p[s] = luminance(d, c_p[s]);
      sum[s] = scaled(c_p[s], centre);
      total[s] = centre;
    }
    for_each_tap(d, row, x, [&](const LevelTap& tap, auto same) HWY_ATTR {
      const float* there = tap.surfaces + x;
      const V distance = kDepthOnly
                             ? squared_distance(z_p, hn::LoadU(d, there + kDepth * pitch))
                             : squared_distance(x_p, load_colour(d, there + kPositionX * pitch, pitch));
      const V turned = squared_distance(n_p, load_colour(d, there + kNormalX * pitch, pitch));
      const V exponent = hn::MulAdd(distance, place, hn::Mul(turned, normal));
      const V h = hn::IfThenElseZero(same, hn::Set(d, tap.h));
      for (int s = 0; s < kSignals; ++s) {
        const Colour c_q = load_colour(d, tap.in + pitch * 3 * s + x, pitch);
        const V difference =
            kLuminance ? squared_distance(y_p[s], luminance(d, c_q)) : squared_distance(c_p[s], c_q);
        const V w = power_of_two(d, hn::MulAdd(hn::Min(difference, largest), light, exponent));
        const V weight = hn::Mul(h, w);
        total[s] = hn::Add(total[s], weight);
        add_weighted(sum[s], weight, c_q);
      }
    });
    const V surface = hn::LoadU(d, here + kId * pitch);
    const auto any = hn::Eq(surface, surface);  // NaN where there is none
    for (int s = 0; s < kSignals; ++s) {
      const Colour mean = scaled(sum[s], hn::Div(hn::Set(d, 1.0F), total[s]));
      store_colour(d, if_then_else(any, mean, c_p[s]), row.out + pitch * 3 * s + x, pitch);
    }
  }
}

template <int kSignals>
void eaw_signals(const LevelRow& row, const EawPrecision& precision, bool luminance, bool depth) {
  if (luminance)
    depth ? eaw_row<kSignals, true, true>(row, precision) : eaw_row<kSignals, true, false>(row, precision);
  else
    depth ? eaw_row<kSignals, false, true>(row, precision) : eaw_row<kSignals, false, false>(row, precision);
}

void eaw_any(const LevelRow& row, const EawPrecision& precision, int signals, bool luminance, bool depth) {
  signals == 1 ? eaw_signals<1>(row, precision, luminance, depth)
               : eaw_signals<2>(row, precision, luminance, depth);
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(eaw_any);

void eaw_level_row(const LevelRow& row, const EawPrecision& precision, int signals, bool luminance,
                   bool depth) {
  HWY_DYNAMIC_DISPATCH(eaw_any)(row, precision, signals, luminance, depth);
}

}  // namespace ld
#endif
