#include "filters/kernels/antialias_row.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filters/kernels/antialias_row.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "filters/kernels/bilinear-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

/// body(row, i, inside) for the 3x3 pixels around those at x.
template <class Body>
HWY_INLINE void for_3x3(D d, const AntialiasRow& row, int64_t x, const Body& body) {
  for (size_t j = 0; j < 3; ++j) {
    if (row.now[j] == nullptr) continue;
    for (int i = -1; i <= 1; ++i) {
      const V at = hn::Iota(d, float(x + i));
      body(j, x + i, hn::And(hn::Ge(at, hn::Zero(d)), hn::Lt(at, hn::Set(d, float(row.width)))));
    }
  }
}

/// Where the nearest surface of the 3x3 pixels was; returns which lanes lie in the picture.
HWY_INLINE hn::Mask<D> nearest_taps(D d, const AntialiasRow& row, int64_t x, BilinearTaps& taps) {
  const DI di;
  V depth = hn::LoadU(d, row.depth[1] + x);
  V flow_x = hn::LoadU(d, row.flow[1] + x), flow_y = hn::LoadU(d, row.flow[1] + row.pitch + x);
  for_3x3(d, row, x, [&](size_t j, int64_t q, auto inside) HWY_ATTR {
    const V other = hn::LoadU(d, row.depth[j] + q);
    const auto nearer = hn::And(inside, hn::Lt(other, depth));
    depth = hn::IfThenElse(nearer, other, depth);
    flow_x = hn::IfThenElse(nearer, hn::LoadU(d, row.flow[j] + q), flow_x);
    flow_y = hn::IfThenElse(nearer, hn::LoadU(d, row.flow[j] + row.pitch + q), flow_y);
  });
  const V zero = hn::Zero(d), half = hn::Set(d, 0.5F);
  const V last_x = hn::Set(d, float(row.width - 1)), last_y = hn::Set(d, float(row.height - 1));
  V px = hn::Add(hn::Iota(d, float(x)), flow_x), py = hn::Add(hn::Set(d, float(row.y)), flow_y);
  const auto found = hn::And(hn::And(hn::Ge(px, hn::Neg(half)), hn::Le(px, hn::Add(last_x, half))),
                             hn::And(hn::Ge(py, hn::Neg(half)), hn::Le(py, hn::Add(last_y, half))));
  px = hn::Min(hn::Max(hn::IfThenElseZero(found, px), zero), last_x);
  py = hn::Min(hn::Max(hn::IfThenElseZero(found, py), zero), last_y);
  const V left = hn::Floor(px), top = hn::Floor(py), fx = hn::Sub(px, left), fy = hn::Sub(py, top);
  const V one = hn::Set(d, 1.0F);
  taps.x[0] = hn::ConvertTo(di, left);
  taps.x[1] = hn::ConvertTo(di, hn::Min(hn::Add(left, one), last_x));
  taps.y[0] = hn::ConvertTo(di, top);
  taps.y[1] = hn::ConvertTo(di, hn::Min(hn::Add(top, one), last_y));
  taps.settle();
  const V gx = hn::Sub(one, fx), gy = hn::Sub(one, fy);
  taps.weight[0] = hn::Mul(gx, gy);
  taps.weight[1] = hn::Mul(fx, gy);
  taps.weight[2] = hn::Mul(gx, fy);
  taps.weight[3] = hn::Mul(fx, fy);
  return found;
}

void antialias(const AntialiasRow& row) {
  const D d;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0F), share = hn::Set(d, row.share);
  for (int64_t x = 0; x < row.width; x += lanes()) {
    BilinearTaps taps;
    const auto found = nearest_taps(d, row, x, taps);
    for (int c = 0; c < 3; ++c) {
      // Moments about the pixel itself: no digits are lost where all are alike.
      const V now = hn::LoadU(d, row.now[1] + c * row.pitch + x);
      V count = zero, sum = zero, squares = zero;
      for_3x3(d, row, x, [&](size_t j, int64_t q, auto inside) HWY_ATTR {
        const V difference =
            hn::IfThenElseZero(inside, hn::Sub(hn::LoadU(d, row.now[j] + c * row.pitch + q), now));
        count = hn::Add(count, hn::IfThenElseZero(inside, one));
        sum = hn::Add(sum, difference);
        squares = hn::MulAdd(difference, difference, squares);
      });
      const V scale = hn::Div(one, hn::Max(count, one)), shift = hn::Mul(sum, scale);
      const V variance = hn::Max(hn::NegMulAdd(shift, shift, hn::Mul(squares, scale)), zero);
      const V mean = hn::Add(now, shift), reach = hn::Mul(hn::Sqrt(variance), hn::Set(d, row.deviations));
      V history = taps.mean(d, row.before, c);
      history = hn::Min(hn::Max(history, hn::Sub(mean, reach)), hn::Add(mean, reach));
      const V blended = hn::MulAdd(share, now, hn::Mul(hn::Sub(one, share), history));
      hn::StoreU(hn::IfThenElse(found, blended, now), d, row.out + c * row.pitch + x);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(antialias);

void antialias_row(const AntialiasRow& row) {
  HWY_DYNAMIC_DISPATCH(antialias)(row);
}

}  // namespace ld
#endif
