#include "ops/kernels/sample_tile.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ops/kernels/sample_tile.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "ops/kernels/exponential-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

void shares_tile(PlanarRow valid, int64_t items, int64_t pixels, float* HWY_RESTRICT share) {
  const D d;
  const V one = hn::Set(d, 1.0f);
  for (int64_t x = 0; x < pixels; x += lanes()) {
    V count = hn::Zero(d);
    for (int64_t i = 0; i < items; ++i) count = hn::Add(count, hn::Load(d, valid.plane(i) + x));
    hn::Store(hn::Div(one, hn::Max(count, one)), d, share + x);
  }
}

/// The mean of value(number) at one vector of pixels.
template <class Value>
HWY_INLINE V mean_at(D d, PlanarRow values, PlanarRow valid, V share, int64_t items, int64_t x,
                     const Value& value) {
  V sum = hn::Zero(d);
  for (int64_t i = 0; i < items; ++i)
    sum = hn::MulAdd(hn::Mul(hn::Load(d, valid.plane(i) + x), share), value(hn::Load(d, values.plane(i) + x)),
                     sum);
  return sum;
}

void mean_tile(PlanarRow values, PlanarRow valid, const float* HWY_RESTRICT share, int64_t items,
               int64_t pixels, float* HWY_RESTRICT mean) {
  const D d;
  for (int64_t x = 0; x < pixels; x += lanes())
    hn::Store(mean_at(d, values, valid, hn::Load(d, share + x), items, x, [](V v) { return v; }), d,
              mean + x);
}

void moments_tile(PlanarRow values, PlanarRow valid, const float* HWY_RESTRICT share, int64_t items,
                  int64_t pixels, float* HWY_RESTRICT mean, float* HWY_RESTRICT variance) {
  const D d;
  for (int64_t x = 0; x < pixels; x += lanes()) {
    const V of_item = hn::Load(d, share + x);
    const V first = mean_at(d, values, valid, of_item, items, x, [](V v) { return v; });
    // The mean of many values is rounded; what it misses is the mean of the rest.
    const V missed = mean_at(d, values, valid, of_item, items, x, [&](V v) { return hn::Sub(v, first); });
    const V spread = mean_at(d, values, valid, of_item, items, x, [&](V v) {
      const V rest = hn::Sub(hn::Sub(v, first), missed);
      return hn::Mul(rest, rest);
    });
    hn::Store(hn::Add(first, missed), d, mean + x);
    hn::Store(spread, d, variance + x);
  }
}

void mask_tile(PlanarTarget planes, int64_t count, const float* HWY_RESTRICT mask, int64_t pixels) {
  const D d;
  for (int64_t c = 0; c < count; ++c) {
    float* HWY_RESTRICT plane = planes.plane(c);
    for (int64_t x = 0; x < pixels; x += lanes())
      hn::Store(hn::Mul(hn::Load(d, plane + x), hn::Load(d, mask + x)), d, plane + x);
  }
}

void demodulate_tile(const DemodulationLimits& limits, PlanarRow albedo, PlanarRow specular,
                     PlanarRow radiance, int64_t pixels, PlanarTarget divisors, PlanarTarget forms) {
  const D d;
  const V least = hn::Set(d, limits.least_reflectance), most = hn::Set(d, limits.most_reflectance);
  for (int64_t x = 0; x < pixels; x += lanes()) {
    V reflectance[3], largest = hn::Zero(d);
    for (int c = 0; c < 3; ++c) {
      V sum = hn::Zero(d);
      for (const PlanarRow part : {albedo, specular})
        if (part.data != nullptr) sum = hn::Add(sum, hn::Load(d, part.plane(c) + x));
      reflectance[c] = sum;
      largest = hn::Max(largest, sum);
    }
    const auto none = hn::Le(largest, hn::Set(d, limits.no_reflectance));
    for (int c = 0; c < 3; ++c) {
      const V divisor = hn::IfThenElse(none, hn::Set(d, 1.0f), hn::Min(hn::Max(reflectance[c], least), most));
      const V light = hn::Load(d, radiance.plane(c) + x);
      hn::Store(divisor, d, divisors.plane(c) + x);
      hn::Store(hn::Div(hn::Min(light, hn::Set(d, limits.largest_radiance)), divisor), d, forms.plane(c) + x);
      hn::Store(light, d, forms.plane(3 + c) + x);
    }
  }
}

void relative_variance_tile(PlanarRow means, PlanarRow variances, int64_t pixels,
                            float* HWY_RESTRICT relative) {
  const D d;
  for (int64_t x = 0; x < pixels; x += lanes()) {
    V sum = hn::Zero(d);
    for (int c = 0; c < 3; ++c) {
      const V mean = hn::Load(d, means.plane(c) + x);
      const V square = hn::IfThenElse(hn::Eq(mean, hn::Zero(d)), hn::Set(d, 1.0f), hn::Mul(mean, mean));
      sum = hn::Add(sum, hn::Div(hn::Load(d, variances.plane(c) + x), square));
    }
    hn::Store(hn::Div(sum, hn::Set(d, 3.0f)), d, relative + x);
  }
}

void reject_tile(const float* HWY_RESTRICT log_n, const float* HWY_RESTRICT logit, float most, int64_t pixels,
                 float* HWY_RESTRICT to) {
  const D d;
  for (int64_t x = 0; x < pixels; x += lanes())
    hn::Store(hn::NegMulAdd(hn::Set(d, most), sigmoid(d, hn::Load(d, logit + x)), hn::Load(d, log_n + x)), d,
              to + x);
}

/// Of pixel x by itself.
float steadiness_at(const RowsAround& values, float falloff, int64_t x) {
  float sum = 0;
  int count = 0;
  for (const float* row : values.rows)
    for (int64_t u = std::max<int64_t>(x - 1, 0); row != nullptr && u <= std::min(x + 1, values.width - 1);
         ++u, ++count)
      sum += row[u];
  return std::exp(-falloff * (sum / float(count)));
}

void steadiness_tile(const RowsAround& values, float falloff, int64_t first, int64_t count,
                     float* HWY_RESTRICT to) {
  const D d;
  float pixels = 0;
  for (const float* row : values.rows) pixels += row != nullptr ? 3.0f : 0.0f;
  const V factor = hn::Set(d, -falloff / pixels);
  for (int64_t x = 0; x < count; x += lanes()) {
    V sum = hn::Zero(d);
    for (const float* row : values.rows) {
      if (row == nullptr) continue;
      const float* from = row + first + x;
      sum = hn::Add(sum, hn::Add(hn::Add(hn::LoadU(d, from - 1), hn::Load(d, from)), hn::LoadU(d, from + 1)));
    }
    hn::Store(exp_negative(d, hn::Mul(factor, sum)), d, to + x);
  }
  // Beyond the borders there is nothing.
  if (first == 0) to[0] = steadiness_at(values, falloff, 0);
  if (first + count == values.width) to[count - 1] = steadiness_at(values, falloff, values.width - 1);
}

void factors_tile(PlanarRow means, const float* HWY_RESTRICT logit, int64_t pixels, PlanarTarget factors) {
  const D d;
  const V zero = hn::Zero(d);
  for (int64_t x = 0; x < pixels; x += lanes()) {
    V brightest = zero;
    for (int c = 0; c < 3; ++c) {
      const V mean = hn::Load(d, means.plane(c) + x);
      brightest = hn::Max(brightest, mean);
      hn::Store(mean, d, factors.plane(c) + x);
    }
    const V beta = hn::IfThenElse(hn::Eq(brightest, zero), zero, sigmoid(d, hn::Load(d, logit + x)));
    hn::Store(beta, d, factors.plane(3) + x);
  }
}

void modulate_tile(const ModulationTile& tile) {
  const D d;
  const PlanarRow in = tile.filtered;
  const int64_t coloured = tile.parts / 3 * 3;
  for (int64_t x = 0; x < tile.pixels; x += lanes()) {
    V mean[3], plain[3], largest = hn::Zero(d);
    for (int c = 0; c < 3; ++c) {
      mean[c] = hn::Load(d, tile.factors.plane(c) + x);
      plain[c] = hn::Load(d, in.plane(3 + c) + x);
      largest = hn::Max(largest, plain[c]);
    }
    const V beta =
        hn::IfThenZeroElse(hn::Gt(largest, hn::Set(d, tile.largest)), hn::Load(d, tile.factors.plane(3) + x));
    for (int c = 0; c < 3; ++c) {
      const V difference = hn::MulSub(mean[c], hn::Load(d, in.plane(c) + x), plain[c]);
      hn::Store(hn::MulAdd(beta, difference, plain[c]), d, tile.out.plane(c) + x);
    }
    const V rest = hn::Sub(hn::Set(d, 1.0f), beta);
    for (int64_t c = 0; c < tile.parts; ++c) {
      V part = hn::Load(d, in.plane(6 + coloured + c) + x);
      if (c < coloured)
        part = hn::MulAdd(beta, hn::Mul(mean[c % 3], hn::Load(d, in.plane(6 + c) + x)), hn::Mul(rest, part));
      hn::Store(part, d, tile.out.plane(3 + c) + x);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(shares_tile);
HWY_EXPORT(mean_tile);
HWY_EXPORT(moments_tile);
HWY_EXPORT(mask_tile);
HWY_EXPORT(demodulate_tile);
HWY_EXPORT(relative_variance_tile);
HWY_EXPORT(reject_tile);
HWY_EXPORT(steadiness_tile);
HWY_EXPORT(factors_tile);
HWY_EXPORT(modulate_tile);

void valid_shares(PlanarRow valid, int64_t items, int64_t pixels, float* share) {
  HWY_DYNAMIC_DISPATCH(shares_tile)(valid, items, pixels, share);
}
void mean_of_items(PlanarRow values, PlanarRow valid, const float* share, int64_t items, int64_t pixels,
                   float* mean) {
  HWY_DYNAMIC_DISPATCH(mean_tile)(values, valid, share, items, pixels, mean);
}
void moments_of_items(PlanarRow values, PlanarRow valid, const float* share, int64_t items, int64_t pixels,
                      float* mean, float* variance) {
  HWY_DYNAMIC_DISPATCH(moments_tile)(values, valid, share, items, pixels, mean, variance);
}
void mask_planes(PlanarTarget planes, int64_t count, const float* mask, int64_t pixels) {
  HWY_DYNAMIC_DISPATCH(mask_tile)(planes, count, mask, pixels);
}
void demodulate(const DemodulationLimits& limits, PlanarRow albedo, PlanarRow specular, PlanarRow radiance,
                int64_t pixels, PlanarTarget divisors, PlanarTarget forms) {
  HWY_DYNAMIC_DISPATCH(demodulate_tile)(limits, albedo, specular, radiance, pixels, divisors, forms);
}
void relative_variance(PlanarRow means, PlanarRow variances, int64_t pixels, float* relative) {
  HWY_DYNAMIC_DISPATCH(relative_variance_tile)(means, variances, pixels, relative);
}
void reject(const float* log_n, const float* logit, float most, int64_t pixels, float* to) {
  HWY_DYNAMIC_DISPATCH(reject_tile)(log_n, logit, most, pixels, to);
}
void steadiness(const RowsAround& values, float falloff, int64_t x, int64_t count, float* to) {
  HWY_DYNAMIC_DISPATCH(steadiness_tile)(values, falloff, x, count, to);
}
void modulation_factors(PlanarRow means, const float* logit, int64_t pixels, PlanarTarget factors) {
  HWY_DYNAMIC_DISPATCH(factors_tile)(means, logit, pixels, factors);
}
void modulate(const ModulationTile& tile) {
  HWY_DYNAMIC_DISPATCH(modulate_tile)(tile);
}

}  // namespace ld
#endif
