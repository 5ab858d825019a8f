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

  HWY_INLINE V mean(D d, const PlaneView& view, int plane) const {
    const DI di;
    const VI pitch = hn::Set(di, int32_t(view.row_pitch));
    const float* const base = view.data + plane * view.pitch;
    V sum = hn::Zero(d);
    for (int t = 0; t < 4; ++t)
      sum = hn::MulAdd(weight[t], hn::GatherIndex(d, base, hn::Add(hn::Mul(y[t / 2], pitch), x[t % 2])), sum);
    return sum;
  }

  /// Mean of v + (m - mean m)^2: the variance of all taps together.
  HWY_INLINE V variance(D d, const PlaneView& view, int plane, V mean_m) const {
    const DI di;
    const VI pitch = hn::Set(di, int32_t(view.row_pitch));
    const float* const base = view.data + plane * view.pitch;
    V sum = hn::Zero(d);
    for (int t = 0; t < 4; ++t) {
      const VI index = hn::Add(hn::Mul(y[t / 2], pitch), x[t % 2]);
      const V difference = hn::Sub(hn::GatherIndex(d, base, index), mean_m);
      const V v = hn::GatherIndex(d, base + view.pitch, index);
      sum = hn::MulAdd(weight[t], hn::MulAdd(difference, difference, v), sum);
    }
    return sum;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#endif
