#include "ops/kernels/splat.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ops/kernels/splat.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "ops/kernels/exponential-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

constexpr int64_t kMostTaps = 31;  // of a kernel's row
constexpr int64_t kBlock = 4;      // channels whose gradients are summed at once
constexpr int kMostAdded = 8;      // channels that are summed at once

/// m_p of every pixel, over all layers and taps; where `argmax` is given, the first plane that has it.
template <bool kArgmax>
HWY_INLINE V largest_logit(D d, StagedRows& logits, int64_t x, int32_t* argmax) {
  const hn::RebindToSigned<D> di;
  V largest = bounded_logit(d, hn::Load(d, logits.row(0) + x));
  auto where = hn::Zero(di);
  for (int64_t k = 1; k < logits.rows(); ++k) {
    const V z = bounded_logit(d, hn::Load(d, logits.row(k) + x));
    if constexpr (kArgmax) {
      const auto larger = hn::Gt(z, largest);
      where = hn::IfThenElse(hn::RebindMask(di, larger), hn::Set(di, int32_t(k)), where);
    }
    largest = hn::Max(largest, z);
  }
  if constexpr (kArgmax) hn::StoreU(where, di, argmax + x);
  return largest;
}

template <bool kArgmax>
HWY_INLINE void exponents(const FilterShape& shape, SplatSourcesRow& sources, int64_t count,
                          int32_t* argmax) {
  const D d;
  for (int64_t x = 0; x < count; x += lanes()) {
    const V largest = largest_logit<kArgmax>(d, sources.logits, x, argmax);
    for (int64_t l = 0; l < shape.layers; ++l) {
      const V log_n = hn::Load(d, sources.log_n.row(l) + x);
      for (int64_t tap = 0; tap < shape.taps(); ++tap) {
        float* z = sources.logits.row(l * shape.taps() + tap) + x;
        const V e = hn::Sub(bounded_logit(d, hn::Load(d, z)), largest);
        hn::Store(hn::Add(hn::Max(e, hn::Set(d, kLowestLogit)), log_n), d, z);
      }
    }
  }
}

void exponents_of_row(const FilterShape& shape, SplatSourcesRow& sources, int64_t count) {
  exponents<false>(shape, sources, count, nullptr);
}

/// channels [c, c + kCount) of a destination vector: sum * rescale + what the taps of one kernel row bring.
template <int kCount>
HWY_INLINE void add_channels(D d, const FilterShape& shape, const float* HWY_RESTRICT weights,
                             const float* HWY_RESTRICT values, int64_t values_pitch, V rescale,
                             float* HWY_RESTRICT sums, int64_t sums_pitch) {
  V sum[kCount];
#pragma GCC unroll 8
  for (int c = 0; c < kCount; ++c) sum[c] = hn::Mul(hn::LoadU(d, sums + c * sums_pitch), rescale);
  for (int64_t dx = 0; dx < shape.kernel; ++dx) {
    const V weight = hn::Load(d, weights + dx * lanes());
#pragma GCC unroll 8
    for (int c = 0; c < kCount; ++c)
      sum[c] = hn::MulAdd(weight, hn::LoadU(d, values + c * values_pitch - dx), sum[c]);
  }
#pragma GCC unroll 8
  for (int c = 0; c < kCount; ++c) hn::StoreU(sum[c], d, sums + c * sums_pitch);
}

/// All of them, as many at once as there are: the weights are read once for each such block.
template <int kCount = kMostAdded>
HWY_INLINE void add_all_channels(D d, const FilterShape& shape, const float* weights, const float* values,
                                 int64_t values_pitch, V rescale, float* sums, int64_t sums_pitch,
                                 int64_t left) {
  for (; left >= kCount; left -= kCount, values += kCount * values_pitch, sums += kCount * sums_pitch)
    add_channels<kCount>(d, shape, weights, values, values_pitch, rescale, sums, sums_pitch);
  if constexpr (kCount > 1)
    add_all_channels<kCount - 1>(d, shape, weights, values, values_pitch, rescale, sums, sums_pitch, left);
}

/// Whether no lane of a vector of destinations from pixel x on is made. Those outside of the picture are not.
HWY_INLINE bool is_skipped(const uint8_t* skips, int64_t blocks, int64_t x) {
  constexpr int64_t kPixels = SplatSkips::kBlock;
  const int64_t first = std::max<int64_t>(x, 0) / kPixels,
                last = std::min((x + lanes() + kPixels - 1) / kPixels, blocks);
  for (int64_t b = first; b < last; ++b)
    if (skips[b] == 0) return false;
  return true;
}

/// One layer's row of taps `dy` to one row of destinations; x counts from the stretch's first pixel.
HWY_INLINE void add_kernel_row(const FilterShape& shape, const SplatSourcesRow& sources, const Stretch& at,
                               int64_t layer, int64_t dy, SplatStrip& strip, const SplatSkips* skips) {
  const D d;
  const int64_t radius = shape.radius();
  float* HWY_RESTRICT to = strip.row(layer, at.y + dy - radius) + at.x;
  const int64_t pitch = strip.pitch();
  const float* HWY_RESTRICT e = sources.logits.row(layer * shape.taps() + dy * shape.kernel) + radius;
  const float* HWY_RESTRICT v = sources.values.row(layer * shape.channels) + radius;
  const int64_t e_step = sources.logits.pitch() - 1;  // the next tap, one source pixel to the left
  HWY_ALIGN float weights[kMostTaps * HWY_MAX_BYTES / sizeof(float)];
  const uint8_t* skipped = skips == nullptr ? nullptr : skips->row(layer, at.y + dy - radius - strip.begin());
  for (int64_t x = -radius; x < at.count + radius; x += lanes()) {
    if (skipped != nullptr && is_skipped(skipped, skips->blocks(), at.x + x)) continue;
    const V before = hn::LoadU(d, to + x);
    V largest = before;
    for (int64_t dx = 0; dx < shape.kernel; ++dx)
      largest = hn::Max(largest, hn::LoadU(d, e + x + dx * e_step));
    const V rescale = exp_negative(d, hn::Sub(before, largest));
    V total = hn::Mul(hn::LoadU(d, to + pitch + x), rescale);
    for (int64_t dx = 0; dx < shape.kernel; ++dx) {
      const V weight = exp_negative(d, hn::Sub(hn::LoadU(d, e + x + dx * e_step), largest));
      total = hn::Add(total, weight);
      hn::Store(weight, d, weights + dx * lanes());
    }
    hn::StoreU(largest, d, to + x);
    hn::StoreU(total, d, to + pitch + x);
    add_all_channels(d, shape, weights, v + x, sources.values.pitch(), rescale, to + 2 * pitch + x, pitch,
                     shape.channels);
  }
}

void add_stretch(const FilterShape& shape, const SplatSourcesRow& sources, const Stretch& at,
                 SplatStrip& strip, const SplatSkips* skips) {
  for (int64_t layer = 0; layer < shape.layers; ++layer)
    for (int64_t dy = 0; dy < shape.kernel; ++dy)
      if (strip.holds(at.y + dy - shape.radius()))
        add_kernel_row(shape, sources, at, layer, dy, strip, skips);
}

/// Row y of one layer from the strips that hold it, in their order.
void merge_layer_row(const FilterShape& shape, int64_t layer, const std::vector<SplatStrip*>& strips,
                     int64_t y, const SplatResult& result) {
  const D d;
  const int64_t plane = result.plane;
  float* HWY_RESTRICT out = result.out + layer * shape.channels * plane;
  SplatStrip* first = nullptr;
  for (SplatStrip* strip : strips) {
    if (!strip->holds(y)) continue;
    if (first == nullptr) {
      first = strip;
      continue;
    }
    // Into the first strip's row, as if its sources had come next.
    float* HWY_RESTRICT a = first->row(layer, y);
    const float* HWY_RESTRICT b = strip->row(layer, y);
    for (int64_t x = 0; x < shape.width; x += lanes()) {
      const V largest_a = hn::LoadU(d, a + x), largest_b = hn::LoadU(d, b + x);
      const V largest = hn::Max(largest_a, largest_b);
      const V scale_a = exp_negative(d, hn::Sub(largest_a, largest)),
              scale_b = exp_negative(d, hn::Sub(largest_b, largest));
      hn::StoreU(largest, d, a + x);
      for (int64_t c = 1; c < 2 + shape.channels; ++c) {
        float* sum = a + c * first->pitch() + x;
        hn::StoreU(hn::MulAdd(hn::LoadU(d, sum), scale_a,
                              hn::Mul(hn::LoadU(d, b + c * strip->pitch() + x), scale_b)),
                   d, sum);
      }
    }
  }
  // Every row of the picture lies in some strip. NOLINTNEXTLINE(clang-analyzer-core.CallAndMessage)
  float* HWY_RESTRICT sums = first->row(layer, y);
  const int64_t pitch = first->pitch();
  for (int64_t x = 0; x < shape.width; x += lanes()) {
    const V total = hn::LoadU(d, sums + pitch + x);
    const auto arrived = hn::Gt(total, hn::Zero(d));
    const V inverse = hn::IfThenElseZero(arrived, hn::Div(hn::Set(d, 1.0f), total));
    hn::StoreU(inverse, d, sums + pitch + x);
    for (int64_t c = 0; c < shape.channels; ++c) {
      float* sum = sums + (2 + c) * pitch + x;
      // A quotient, not a product with the inverse: a mean of equal values is that value.
      hn::StoreU(hn::IfThenElseZero(arrived, hn::Div(hn::LoadU(d, sum), total)), d, sum);
    }
  }
  for (int64_t c = 0; c < shape.channels; ++c)
    std::copy_n(sums + (2 + c) * pitch, shape.width, out + c * plane);
  if (result.largest != nullptr) std::copy_n(sums, shape.width, result.largest + layer * plane);
  if (result.inverse != nullptr) std::copy_n(sums + pitch, shape.width, result.inverse + layer * plane);
}

/// Gradients of the exponents at one vector of sources from channels [c, c + kCount), added to those of the
/// channels before; the gradients of the values.
template <int kCount>
HWY_INLINE void pull_channels(D d, const FilterShape& shape, const SplatSourcesRow& sources,
                              SplatDestinations& to, const Stretch& at, int64_t layer, int64_t c, int64_t x,
                              SplatGradientRow& gradients) {
  V value[kCount], value_gradient[kCount];
#pragma GCC unroll 4
  for (int i = 0; i < kCount; ++i) {
    value[i] = hn::Load(d, sources.values.row(layer * shape.channels + c + i) + x);
    value_gradient[i] = hn::Zero(d);
  }
  const int64_t radius = shape.radius(), pitch = to.pitch();
  for (int64_t dy = 0; dy < shape.kernel; ++dy) {
    const int64_t y = at.y + dy - radius;
    if (y < 0 || y >= shape.height) continue;
    const float* HWY_RESTRICT g = to.row(layer, y) + (2 + 2 * c) * pitch + at.x + x - radius;
    for (int64_t dx = 0; dx < shape.kernel; ++dx, ++g) {
      const int64_t k = layer * shape.taps() + dy * shape.kernel + dx;
      const V p = hn::Load(d, sources.logits.row(k) + x);
      float* pull_at = gradients.logits.row(k) + x;
      V pull = hn::Load(d, pull_at);
#pragma GCC unroll 4
      for (int64_t i = 0; i < kCount; ++i) {
        const V gradient = hn::LoadU(d, g + 2 * i * pitch), result = hn::LoadU(d, g + (2 * i + 1) * pitch);
        // The probability first: a value of 1e32 that has none must give 0.
        pull = hn::MulAdd(gradient, hn::Mul(p, hn::Sub(value[i], result)), pull);
        value_gradient[i] = hn::MulAdd(p, gradient, value_gradient[i]);
      }
      hn::Store(pull, d, pull_at);
    }
  }
#pragma GCC unroll 4
  for (int i = 0; i < kCount; ++i)
    hn::Store(value_gradient[i], d, gradients.values.row(layer * shape.channels + c + i) + x);
}

/// Exponents to probabilities at their destinations; 0 for taps that leave the picture.
HWY_INLINE void probabilities(D d, const FilterShape& shape, SplatSourcesRow& sources, SplatDestinations& to,
                              const Stretch& at, int64_t layer, int64_t x) {
  const int64_t radius = shape.radius();
  for (int64_t dy = 0; dy < shape.kernel; ++dy) {
    const int64_t y = at.y + dy - radius;
    const bool inside = y >= 0 && y < shape.height;
    const float* HWY_RESTRICT largest = inside ? to.row(layer, y) + at.x + x - radius : nullptr;
    for (int64_t dx = 0; dx < shape.kernel; ++dx) {
      float* e = sources.logits.row(layer * shape.taps() + dy * shape.kernel + dx) + x;
      V p = hn::Zero(d);
      if (inside) {
        const V exponent = hn::Sub(hn::Load(d, e), hn::LoadU(d, largest + dx));
        p = hn::Mul(exp_negative(d, exponent), hn::LoadU(d, largest + to.pitch() + dx));
      }
      hn::Store(p, d, e);
    }
  }
}

void backward_stretch(const FilterShape& shape, SplatSourcesRow& sources, SplatDestinations& to,
                      const Stretch& at, SplatGradientRow& gradients) {
  const D d;
  exponents<true>(shape, sources, at.count, gradients.argmax.data());
  sources.logits.fill_behind(at.count, -std::numeric_limits<float>::infinity());
  for (int64_t x = 0; x < at.count; x += lanes()) {
    V maximum = hn::Zero(d);
    for (int64_t layer = 0; layer < shape.layers; ++layer) {
      probabilities(d, shape, sources, to, at, layer, x);
      for (int64_t tap = 0; tap < shape.taps(); ++tap)
        hn::Store(hn::Zero(d), d, gradients.logits.row(layer * shape.taps() + tap) + x);
      int64_t c = 0;
      for (; c + kBlock <= shape.channels; c += kBlock)
        pull_channels<kBlock>(d, shape, sources, to, at, layer, c, x, gradients);
      for (; c < shape.channels; ++c) pull_channels<1>(d, shape, sources, to, at, layer, c, x, gradients);
      V log_n = hn::Zero(d);
      for (int64_t tap = 0; tap < shape.taps(); ++tap)
        log_n = hn::Add(log_n, hn::Load(d, gradients.logits.row(layer * shape.taps() + tap) + x));
      hn::Store(log_n, d, gradients.log_n.row(layer) + x);
      maximum = hn::Sub(maximum, log_n);
    }
    HWY_ALIGN float of_maximum[HWY_MAX_BYTES / sizeof(float)];
    hn::Store(maximum, d, of_maximum);
    for (int64_t i = 0; i < std::min(lanes(), at.count - x); ++i)
      gradients.logits.row(gradients.argmax[size_t(x + i)])[x + i] += of_maximum[i];
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

SplatStrip::SplatStrip(const FilterShape& shape, bool joint, int64_t first, int64_t last)
    : begin_(0),
      end_(0),
      planes_(2 + shape.channels),
      joint_(joint),
      rows_((joint ? 1 : shape.layers) * (last - first + 2 * shape.radius()) * planes_, shape.width,
            2 * shape.radius(), 0.0f) {
  restart(shape, first, last);
}

void SplatStrip::restart(const FilterShape& shape, int64_t first, int64_t last) {
  begin_ = std::max<int64_t>(first - shape.radius(), 0);
  end_ = std::min(last + shape.radius(), shape.height);
  for (int64_t r = 0; r < (joint_ ? 1 : shape.layers) * (end_ - begin_) * planes_; ++r)
    // The largest exponent so far: below all others, and finite, so that differences are no NaN.
    std::fill_n(rows_.row(r) - row_margin(2 * shape.radius()), rows_.pitch(),
                r % planes_ == 0 ? std::numeric_limits<float>::lowest() : 0.0f);
}

SplatSourcesRow::SplatSourcesRow(const FilterShape& shape, int64_t pixels)
    : logits(shape.layers * shape.taps(), pixels, 2 * shape.radius(), kMinusInfinity),
      log_n(shape.layers, pixels, 0, kMinusInfinity),
      values(shape.layers * shape.channels, pixels, 2 * shape.radius(), 0.0f) {}

SplatGradientRow::SplatGradientRow(const FilterShape& shape, int64_t pixels)
    : logits(shape.layers * shape.taps(), pixels, 0, 0.0f),
      log_n(shape.layers, pixels, 0, 0.0f),
      values(shape.layers * shape.channels, pixels, 0, 0.0f),
      argmax(size_t(padded(pixels))) {}

SplatDestinations::SplatDestinations(const FilterShape& shape, bool joint)
    : height_(shape.height),
      channels_(shape.channels),
      joint_(joint),
      rows_((joint ? 1 : shape.layers) * shape.height * (2 + 2 * shape.channels), shape.width,
            shape.radius() + kPixelStep, 0.0f) {
  // Outside of the picture nothing arrives: below the largest exponent there everything is 0.
  for (int64_t r = 0; r < rows_.rows(); r += planes())
    std::fill_n(rows_.row(r) - row_margin(shape.radius() + kPixelStep), rows_.pitch(),
                std::numeric_limits<float>::max());
}

void SplatDestinations::fill_row(const SplatResult& saved, const float* gradient, int64_t width,
                                 int64_t layers, int64_t y) {
  const int64_t plane = saved.plane, offset = y * width;
  for (int64_t l = 0; l < (joint_ ? 1 : layers); ++l) {
    float* to = row(l, y);
    std::copy_n(saved.largest + l * plane + offset, width, to);
    std::copy_n(saved.inverse + l * plane + offset, width, to + pitch());
    for (int64_t c = 0; c < channels_; ++c) {
      const int64_t from = (l * channels_ + c) * plane + offset;
      std::copy_n(gradient + from, width, to + (2 + 2 * c) * pitch());
      std::copy_n(saved.out + from, width, to + (3 + 2 * c) * pitch());
    }
  }
}

HWY_EXPORT(exponents_of_row);
HWY_EXPORT(add_stretch);
HWY_EXPORT(merge_layer_row);
HWY_EXPORT(backward_stretch);

void splat_exponents(const FilterShape& shape, SplatSourcesRow& sources, int64_t count) {
  HWY_DYNAMIC_DISPATCH(exponents_of_row)(shape, sources, count);
  sources.logits.fill_behind(count, kMinusInfinity);
}

void splat_stretch(const FilterShape& shape, const SplatSourcesRow& sources, const Stretch& at,
                   SplatStrip& strip, const SplatSkips* skips) {
  HWY_DYNAMIC_DISPATCH(add_stretch)(shape, sources, at, strip, skips);
}

void merge_row(const FilterShape& shape, bool joint, const std::vector<SplatStrip*>& strips, int64_t y,
               const SplatResult& result) {
  for (int64_t layer = 0; layer < (joint ? 1 : shape.layers); ++layer)
    HWY_DYNAMIC_DISPATCH(merge_layer_row)(shape, layer, strips, y, result);
}

void splat_stretch_backward(const FilterShape& shape, SplatSourcesRow& sources, SplatDestinations& to,
                            const Stretch& at, SplatGradientRow& gradients) {
  HWY_DYNAMIC_DISPATCH(backward_stretch)(shape, sources, to, at, gradients);
}

}  // namespace ld
#endif
