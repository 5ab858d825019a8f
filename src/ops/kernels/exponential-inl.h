// Included once for every instruction set: what the filters and the partition compute with.
#if defined(LD_EXPONENTIAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LD_EXPONENTIAL_INL_H_
#undef LD_EXPONENTIAL_INL_H_
#else
#define LD_EXPONENTIAL_INL_H_
#endif

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "ops/kernels/filter.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

HWY_INLINE int64_t lanes() {
  return int64_t(hn::Lanes(D()));
}

/// exp(x) for x <= 0. What would be below the smallest normal number is 0: beside a largest weight of 1 it is
/// lost to rounding anyway, and denormal numbers would slow every later loop.
HWY_INLINE V exp_negative(D d, V x) {
  return hn::IfThenElseZero(hn::Ge(x, hn::Set(d, -87.336544f)), hn::Exp(d, x));
}

/// A logit within its range; NaN as the lowest.
HWY_INLINE V bounded_logit(D d, V z) {
  const V lowest = hn::Set(d, kLowestLogit);
  return hn::IfThenElse(hn::Gt(z, lowest), hn::Min(z, hn::Neg(lowest)), lowest);
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#endif
