#include "ops/kernels/gather.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ops/kernels/gather.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "ops/kernels/exponential-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

/// Calls body(tap, source) for the taps inside the picture's rows: `source` is log n at the vector's first
/// source; the channels follow, a pitch apart.
template <class Body>
HWY_INLINE void for_each_tap(const FilterShape& shape, const GatherSources& sources, const Stretch& at,
                             int64_t x, const Body& body) {
  for (int64_t dy = 0; dy < shape.kernel; ++dy) {
    const int64_t y = at.y + dy - shape.radius();
    if (y < 0 || y >= shape.height) continue;
    const float* source = sources.row(y) + at.x + x - shape.radius();
    for (int64_t dx = 0; dx < shape.kernel; ++dx) body(dy * shape.kernel + dx, source + dx);
  }
}

void stretch_forward(const FilterShape& shape, const GatherSources& sources, const Stretch& at,
                     GatherRow& row) {
  const D d;
  for (int64_t x = 0; x < at.count; x += lanes()) {
    // Finite, so that a pixel that receives nothing has no -inf - -inf.
    V largest = hn::Set(d, std::numeric_limits<float>::lowest());
    for_each_tap(shape, sources, at, x, [&](int64_t tap, const float* source) {
      float* z = row.logits.row(tap) + x;
      const V e = hn::Add(bounded_logit(d, hn::Load(d, z)), hn::LoadU(d, source));
      hn::Store(e, d, z);
      largest = hn::Max(largest, e);
    });
    V total = hn::Zero(d);
    for_each_tap(shape, sources, at, x, [&](int64_t tap, const float*) {
      float* e = row.logits.row(tap) + x;
      const V weight = exp_negative(d, hn::Sub(hn::Load(d, e), largest));
      hn::Store(weight, d, e);
      total = hn::Add(total, weight);
    });
    const auto arrived = hn::Gt(total, hn::Zero(d));
    hn::Store(largest, d, row.totals.row(0) + x);
    hn::Store(hn::IfThenElseZero(arrived, hn::Div(hn::Set(d, 1.0f), total)), d, row.totals.row(1) + x);
    for (int64_t c = 0; c < shape.channels; ++c) {
      V sum = hn::Zero(d);
      for_each_tap(shape, sources, at, x, [&](int64_t tap, const float* source) {
        sum = hn::MulAdd(hn::Load(d, row.logits.row(tap) + x),
                         hn::LoadU(d, source + (1 + c) * sources.pitch()), sum);
      });
      hn::Store(hn::IfThenElseZero(arrived, hn::Div(sum, total)), d, row.out.row(c) + x);
    }
  }
}

/// What one row of taps sends back to one row of values: probability times gradient.
HWY_INLINE void push_kernel_row(const FilterShape& shape, const Stretch& at, int64_t dy, int64_t channel,
                                const GatherGradientRow& row, float* HWY_RESTRICT to) {
  const D d;
  const int64_t radius = shape.radius();
  const float* HWY_RESTRICT g = row.gradient.row(channel) + radius;
  const float* HWY_RESTRICT p = row.logits.row(dy * shape.kernel) + radius;
  for (int64_t x = -radius; x < at.count + radius; x += lanes()) {
    V sum = hn::LoadU(d, to + at.x + x);
    for (int64_t dx = 0; dx < shape.kernel; ++dx)
      sum = hn::MulAdd(hn::LoadU(d, p + dx * (row.logits.pitch() - 1) + x), hn::LoadU(d, g + x - dx), sum);
    hn::StoreU(sum, d, to + at.x + x);
  }
}

void stretch_backward(const FilterShape& shape, const GatherSources& sources, const Stretch& at,
                      GatherGradientRow& row, GatherStrip* values_gradient) {
  const D d;
  for (int64_t x = 0; x < at.count; x += lanes()) {
    const V largest = hn::Load(d, row.totals.row(0) + x), inverse = hn::Load(d, row.totals.row(1) + x);
    for_each_tap(shape, sources, at, x, [&](int64_t tap, const float* source) {
      float* z = row.logits.row(tap) + x;
      const V e = hn::Add(bounded_logit(d, hn::Load(d, z)), hn::LoadU(d, source));
      const V p = hn::Mul(exp_negative(d, hn::Sub(e, largest)), inverse);
      hn::Store(p, d, z);
      V pull = hn::Zero(d);
      for (int64_t c = 0; c < shape.channels; ++c) {
        const V difference =
            hn::Sub(hn::LoadU(d, source + (1 + c) * sources.pitch()), hn::Load(d, row.out.row(c) + x));
        // The probability first: a value of 1e32 that has none must give 0.
        pull = hn::MulAdd(hn::Load(d, row.gradient.row(c) + x), hn::Mul(p, difference), pull);
      }
      hn::Store(pull, d, row.logits_gradient.row(tap) + x);
    });
  }
  const int64_t radius = shape.radius();
  for (int64_t dy = 0; dy < shape.kernel; ++dy) {
    const int64_t y = at.y + dy - radius;
    if (y >= 0 && y < shape.height) continue;
    for (int64_t dx = 0; dx < shape.kernel; ++dx)
      std::fill_n(row.logits_gradient.row(dy * shape.kernel + dx), padded(at.count), 0.0f);
  }
  if (values_gradient == nullptr) return;
  row.logits.fill_behind(at.count, 0.0f);
  for (int64_t dy = 0; dy < shape.kernel; ++dy) {
    const int64_t y = at.y + dy - radius;
    if (y < 0 || y >= shape.height) continue;
    for (int64_t c = 0; c < shape.channels; ++c)
      push_kernel_row(shape, at, dy, c, row, values_gradient->row(c, y));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {
namespace {
constexpr float kMinusInfinity = -std::numeric_limits<float>::infinity();
}

GatherSources::GatherSources(const FilterShape& shape, int64_t capacity)
    : planes_(1 + shape.channels),
      capacity_(capacity),
      rows_(capacity * planes_, shape.width, shape.radius() + kPixelStep, 0.0f) {
  for (int64_t y = 0; y < capacity; ++y)
    std::fill_n(rows_.row(y * planes_) - row_margin(shape.radius() + kPixelStep), rows_.pitch(),
                kMinusInfinity);
}

GatherRow::GatherRow(const FilterShape& shape, int64_t pixels)
    : logits(shape.taps(), pixels, 0, 0.0f),
      totals(2, pixels, 0, 0.0f),
      out(shape.channels, pixels, 0, 0.0f) {}

GatherStrip::GatherStrip(const FilterShape& shape, int64_t first, int64_t last)
    : begin_(std::max<int64_t>(first - shape.radius(), 0)),
      end_(std::min(last + shape.radius(), shape.height)),
      rows_(shape.channels * (end_ - begin_), shape.width, 2 * shape.radius(), 0.0f) {}

GatherGradientRow::GatherGradientRow(const FilterShape& shape, int64_t pixels)
    : logits(shape.taps(), pixels, 2 * shape.radius(), 0.0f),
      totals(2, pixels, 0, 0.0f),
      out(shape.channels, pixels, 0, 0.0f),
      gradient(shape.channels, pixels, 2 * shape.radius(), 0.0f),
      logits_gradient(shape.taps(), pixels, 0, 0.0f) {}

HWY_EXPORT(stretch_forward);
HWY_EXPORT(stretch_backward);

void gather_stretch(const FilterShape& shape, const GatherSources& sources, const Stretch& at,
                    GatherRow& row) {
  HWY_DYNAMIC_DISPATCH(stretch_forward)(shape, sources, at, row);
}

void gather_stretch_backward(const FilterShape& shape, const GatherSources& sources, const Stretch& at,
                             GatherGradientRow& row, GatherStrip* values_gradient) {
  HWY_DYNAMIC_DISPATCH(stretch_backward)(shape, sources, at, row, values_gradient);
}

}  // namespace ld
#endif
