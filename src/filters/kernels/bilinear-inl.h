// Included once for every instruction set: what lay between four pixels of the previous frame.
#if defined(LD_FILTERS_BILINEAR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LD_FILTERS_BILINEAR_INL_H_
#undef LD_FILTERS_BILINEAR_INL_H_
#else
#define LD_FILTERS_BILINEAR_INL_H_
#endif

#include "filters/kernels/plane_view.h"
#include "ops/kernels/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

using DI = hn::RebindToSigned<D>;
using VI = hn::Vec<DI>;

/// The four pixels around p' in the previous frame and their weights, which add up to 1 where one is found.
struct BilinearTaps {
  VI x[2], y[2];
  V weight[4];
  // Whether the lanes' taps lie side by side, as they do where all moves alike: then from `left` on in these
  // rows, and loads take the place of gathers, which take ten times as long.
  bool together = false;
  int64_t left = 0, row[2] = {0, 0};

  /// Once x and y are there.
  HWY_INLINE void settle() {
    const DI di;
    left = hn::GetLane(x[0]);
    const VI columns = hn::Add(hn::Set(di, int32_t(left)), hn::Iota(di, 0));
    auto same = hn::And(hn::Eq(x[0], columns), hn::Eq(x[1], hn::Add(columns, hn::Set(di, 1))));
    for (int j = 0; j < 2; ++j) {
      row[j] = hn::GetLane(y[j]);
      same = hn::And(same, hn::Eq(y[j], hn::Set(di, int32_t(row[j]))));
    }
    together = hn::AllTrue(di, same);
  }

  HWY_INLINE V tap(D d, const PlaneView& view, int plane, int t) const {
    const float* const base = view.data + plane * view.pitch;
    if (together) return hn::LoadU(d, base + row[t / 2] * view.row_pitch + left + t % 2);
    const VI pitch = hn::Set(DI(), int32_t(view.row_pitch));
    return hn::GatherIndex(d, base, hn::Add(hn::Mul(y[t / 2], pitch), x[t % 2]));
  }

  HWY_INLINE V mean(D d, const PlaneView& view, int plane) const {
    V sum = hn::Zero(d);
    for (int t = 0; t < 4; ++t) sum = hn::MulAdd(weight[t], tap(d, view, plane, t), sum);
    return sum;
  }

  /// Mean of v + (m - mean m)^2: the variance of all taps together.
  HWY_INLINE V variance(D d, const PlaneView& view, int plane, V mean_m) const {
    V sum = hn::Zero(d);
    for (int t = 0; t < 4; ++t) {
      const V difference = hn::Sub(tap(d, view, plane, t), mean_m), v = tap(d, view, plane + 1, t);
      sum = hn::MulAdd(weight[t], hn::MulAdd(difference, difference, v), sum);
    }
    return sum;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#endif
