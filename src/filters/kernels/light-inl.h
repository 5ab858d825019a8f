// Included once for every instruction set: light as the filters see it.
#if defined(LD_FILTERS_LIGHT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LD_FILTERS_LIGHT_INL_H_
#undef LD_FILTERS_LIGHT_INL_H_
#else
#define LD_FILTERS_LIGHT_INL_H_
#endif

#include <hwy/cache_control.h>

#include "filters/kernels/level_row.h"
#include "filters/kernels/luminance.h"
#include "filters/kernels/surfaces.h"
#include "ops/kernels/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

struct Colour {
  V r, g, b;
};

/// Three planes, `pitch` floats apart.
HWY_INLINE Colour load_colour(D d, const float* plane, int64_t pitch) {
  return {hn::LoadU(d, plane), hn::LoadU(d, plane + pitch), hn::LoadU(d, plane + 2 * pitch)};
}

HWY_INLINE void store_colour(D d, const Colour& colour, float* plane, int64_t pitch) {
  hn::StoreU(colour.r, d, plane);
  hn::StoreU(colour.g, d, plane + pitch);
  hn::StoreU(colour.b, d, plane + 2 * pitch);
}

HWY_INLINE V luminance(D d, const Colour& c) {
  return hn::MulAdd(c.r, hn::Set(d, kLuminanceRed),
                    hn::MulAdd(c.g, hn::Set(d, kLuminanceGreen), hn::Mul(c.b, hn::Set(d, kLuminanceBlue))));
}

/// |a - b|^2
HWY_INLINE V squared_distance(const Colour& a, const Colour& b) {
  const V r = hn::Sub(a.r, b.r), g = hn::Sub(a.g, b.g), blue = hn::Sub(a.b, b.b);
  return hn::MulAdd(r, r, hn::MulAdd(g, g, hn::Mul(blue, blue)));
}

HWY_INLINE V squared_distance(V a, V b) {
  const V difference = hn::Sub(a, b);
  return hn::Mul(difference, difference);
}

HWY_INLINE V dot(const Colour& a, const Colour& b) {
  return hn::MulAdd(a.r, b.r, hn::MulAdd(a.g, b.g, hn::Mul(a.b, b.b)));
}

HWY_INLINE void add_weighted(Colour& sum, V weight, const Colour& c) {
  sum.r = hn::MulAdd(weight, c.r, sum.r);
  sum.g = hn::MulAdd(weight, c.g, sum.g);
  sum.b = hn::MulAdd(weight, c.b, sum.b);
}

HWY_INLINE Colour scaled(const Colour& c, V factor) {
  return {hn::Mul(c.r, factor), hn::Mul(c.g, factor), hn::Mul(c.b, factor)};
}

template <class M>
HWY_INLINE Colour if_then_else(M mask, const Colour& a, const Colour& b) {
  return {hn::IfThenElse(mask, a.r, b.r), hn::IfThenElse(mask, a.g, b.g), hn::IfThenElse(mask, a.b, b.b)};
}

/// 2^x for x <= 0, to 1e-7 of it, 1 for 0; what would be below the smallest normal number is 0. The weights
/// take powers of two because their rounding to a whole exponent is exact and needs no conversion: the sum
/// with 3 * 2^22 has it in its lowest bits.
HWY_INLINE V power_of_two(D d, V x) {
  const hn::RebindToSigned<D> di;
  const V shift = hn::Set(d, 12582912.0F), shifted = hn::Add(x, shift);
  const V r = hn::Sub(x, hn::Sub(shifted, shift));  // |r| <= 1/2
  // Least largest relative error of degree 5 with 2^0 = 1, in pairs: a chain of five products would be waited
  // for.
  const V square = hn::Mul(r, r);
  const V first = hn::MulAdd(hn::Set(d, 6.931469776e-1F), r, hn::Set(d, 1.0F));
  const V second = hn::MulAdd(hn::Set(d, 5.550733744e-2F), r, hn::Set(d, 2.402224208e-1F));
  const V third = hn::MulAdd(hn::Set(d, 1.326472698e-3F), r, hn::Set(d, 9.671512682e-3F));
  const V p = hn::MulAdd(hn::MulAdd(third, square, second), square, first);
  const auto exponent = hn::ShiftLeft<23>(hn::BitCast(di, shifted));
  const V scaled = hn::BitCast(d, hn::Add(hn::BitCast(di, p), exponent));
  return hn::IfThenElseZero(hn::Ge(x, hn::Set(d, -125.0F)), scaled);
}

constexpr float kLog2E = 1.44269504F;

/// Fetches what the next row will be the first to read at x.
HWY_INLINE void fetch_ahead(const LevelRow& row, int64_t x) {
  constexpr int64_t kLine = 16;  // floats
  if (row.next_in == nullptr || x % kLine != 0) return;
  for (int64_t p = 0; p < kSurfacePlanes; ++p) hwy::Prefetch(row.next_surfaces + p * row.pitch + x);
  for (int64_t p = 0; p < row.in_planes; ++p) hwy::Prefetch(row.next_in + p * row.pitch + x);
}

/// body(tap, same) for the taps of the pixels at x, row by row: `same` are the lanes in which here and there
/// is the same surface.
template <class Body>
HWY_INLINE void for_each_tap(D d, const LevelRow& row, int64_t x, const Body& body) {
  const V surface = hn::LoadU(d, row.surfaces + kId * row.pitch + x);
  for (int t = 0; t < row.count; ++t) {
    const LevelTap& tap = row.taps[size_t(t)];
    const auto same = hn::Eq(surface, hn::LoadU(d, tap.surfaces + kId * row.pitch + x));
    if (!hn::AllFalse(d, same)) body(tap, same);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#endif
