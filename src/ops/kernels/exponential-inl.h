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
#include "ops/kernels/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

/// exp(x) for x <= 0, to 2 units in the last place. What would be below the smallest normal number is 0:
/// beside a largest weight of 1 it is lost to rounding anyway, and denormal numbers would slow every later
/// loop. So the power of two can be added to the exponent's bits, where hn::Exp takes two products and more.
HWY_INLINE V exp_negative(D d, V x) {
  const hn::RebindToSigned<D> di;
  const V n = hn::Round(hn::Mul(x, hn::Set(d, 1.44269504f)));
  // x - n log 2, log 2 in two parts of which the first has few digits; |r| <= log(2) / 2.
  const V r = hn::NegMulAdd(n, hn::Set(d, -2.12194440e-4f), hn::NegMulAdd(n, hn::Set(d, 0.693359375f), x));
  // The polynomial of Cephes' expf (Moshier 1992).
  V p = hn::MulAdd(hn::Set(d, 1.9875691500e-4f), r, hn::Set(d, 1.3981999507e-3f));
  p = hn::MulAdd(p, r, hn::Set(d, 8.3334519073e-3f));
  p = hn::MulAdd(p, r, hn::Set(d, 4.1665795894e-2f));
  p = hn::MulAdd(p, r, hn::Set(d, 1.6666665459e-1f));
  p = hn::MulAdd(p, r, hn::Set(d, 5.0000001201e-1f));
  p = hn::Add(hn::MulAdd(p, hn::Mul(r, r), r), hn::Set(d, 1.0f));
  const auto power = hn::ShiftLeft<23>(hn::ConvertTo(di, n));
  const V scaled = hn::BitCast(d, hn::Add(hn::BitCast(di, p), power));
  return hn::IfThenElseZero(hn::Ge(x, hn::Set(d, -87.336544f)), scaled);
}

/// 1 / (1 + exp(-x)); no power overflows. NaN stays.
HWY_INLINE V sigmoid(D d, V x) {
  const V one = hn::Set(d, 1.0f), e = exp_negative(d, hn::Neg(hn::Abs(x)));
  const V above = hn::Div(hn::IfThenElse(hn::Lt(x, hn::Zero(d)), e, one), hn::Add(one, e));
  return hn::IfThenElse(hn::Ne(x, x), x, above);
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
