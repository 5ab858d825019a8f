#include "ops/splat_loops.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ld {
namespace {

template <class T>
constexpr T kMinusInfinity = -std::numeric_limits<T>::infinity();
/// Floor of a tap's exponent: keeps e_l + log n_l finite for every finite logit.
template <class T>
constexpr T kLowest = std::numeric_limits<T>::lowest() / 4;
/// log of the smallest normal number. Smaller weights, beside a largest of 1, are lost to rounding anyway,
/// and denormal numbers would slow every later loop.
template <class T>
const T kSmallestExponent = std::log(std::numeric_limits<T>::min());

/// The part of a row that one tap connects: destinations [begin, end), whose sources lie at x - dx in row
/// `row`.
struct Reach {
  int64_t row, dx, begin, end;
  bool empty() const { return begin >= end; }
};

Reach arriving(const SplatShape& shape, int64_t tap, const Stretch& at) {
  const int64_t radius = shape.kernel / 2, dy = tap / shape.kernel - radius, dx = tap % shape.kernel - radius;
  const int64_t row = at.y - dy;
  if (row < 0 || row >= shape.height) return {row, dx, 0, 0};
  return {row, dx, std::max(at.begin, dx), std::min(at.end, shape.width + dx)};
}

/// Sources [begin, end) of row y that one tap takes to row `row`, at x + dx.
Reach leaving(const SplatShape& shape, int64_t tap, int64_t y) {
  const int64_t radius = shape.kernel / 2, dy = tap / shape.kernel - radius, dx = tap % shape.kernel - radius;
  const int64_t row = y + dy;
  if (row < 0 || row >= shape.height) return {row, dx, 0, 0};
  return {row, dx, std::max<int64_t>(0, -dx), std::min(shape.width, shape.width - dx)};
}

template <class T>
void add_product(const T* __restrict a, const T* __restrict b, T* __restrict out, int64_t count) {
  for (int64_t i = 0; i < count; ++i) out[i] += a[i] * b[i];
}

}  // namespace

template <class T>
void splat_maximum(const SplatShape& shape, const T* logits, T* maximum, int32_t* argmax, const Stretch& at) {
  const int64_t offset = at.y * shape.width + at.begin, count = at.count();
  T* __restrict largest = maximum + offset;
  int32_t* __restrict where = argmax + offset;
  std::copy_n(logits + offset, count, largest);
  std::fill_n(where, count, 0);
  for (int64_t k = 1; k < shape.layers * shape.taps(); ++k) {
    const T* __restrict row = logits + k * shape.plane() + offset;
    for (int64_t i = 0; i < count; ++i) {
      const bool larger = row[i] > largest[i];
      where[i] = larger ? int32_t(k) : where[i];
      largest[i] = larger ? row[i] : largest[i];
    }
  }
}

template <class T>
void splat_exponents(const SplatShape& shape, int64_t layer, const T* logits, const T* maximum,
                     const T* log_n, T* exponents, T* largest, const Stretch& at) {
  const int64_t count = at.count();
  std::fill_n(largest, count, kMinusInfinity<T>);
  std::fill_n(exponents, shape.taps() * count, kMinusInfinity<T>);
  for (int64_t tap = 0; tap < shape.taps(); ++tap) {
    const Reach reach = arriving(shape, tap, at);
    if (reach.empty()) continue;
    const int64_t source = reach.row * shape.width + reach.begin - reach.dx;
    const T* __restrict logit = logits + (layer * shape.taps() + tap) * shape.plane() + source;
    const T* __restrict m = maximum + source;
    const T* __restrict n = log_n + layer * shape.plane() + source;
    T* __restrict exponent = exponents + tap * count + reach.begin - at.begin;
    T* __restrict top = largest + reach.begin - at.begin;
    for (int64_t i = 0; i < reach.end - reach.begin; ++i) {
      const T e = logit[i] - m[i];
      exponent[i] = (e > kLowest<T> ? e : kLowest<T>)+n[i];
      top[i] = exponent[i] > top[i] ? exponent[i] : top[i];
    }
  }
  // Where nothing arrives the largest is -inf: subtract 0 there instead, -inf - -inf being NaN.
  for (int64_t i = 0; i < count; ++i) largest[i] = largest[i] > kMinusInfinity<T> ? largest[i] : T(0);
  const T smallest = kSmallestExponent<T>;
  for (int64_t tap = 0; tap < shape.taps(); ++tap) {
    T* __restrict exponent = exponents + tap * count;
    const T* __restrict top = largest;
    for (int64_t i = 0; i < count; ++i) {
      const T e = exponent[i] - top[i];
      exponent[i] = e < smallest ? kMinusInfinity<T> : e;
    }
  }
}

template <class T>
void splat_values(const SplatShape& shape, int64_t layer, T* weights, const T* values, T* probabilities,
                  T* out, T* total, const Stretch& at) {
  const int64_t count = at.count();
  T* __restrict inverse = total;
  std::fill_n(inverse, count, T(0));
  for (int64_t tap = 0; tap < shape.taps(); ++tap) {
    const T* __restrict weight = weights + tap * count;
    for (int64_t i = 0; i < count; ++i) inverse[i] += weight[i];
  }
  for (int64_t i = 0; i < count; ++i) inverse[i] = inverse[i] > T(0) ? T(1) / inverse[i] : T(0);

  for (int64_t c = 0; c < shape.channels; ++c)
    std::fill_n(out + (layer * shape.channels + c) * shape.plane() + at.y * shape.width + at.begin, count,
                T(0));
  for (int64_t tap = 0; tap < shape.taps(); ++tap) {
    const Reach reach = arriving(shape, tap, at);
    if (reach.empty()) continue;
    const int64_t source = reach.row * shape.width + reach.begin - reach.dx, first = reach.begin - at.begin;
    const int64_t reached = reach.end - reach.begin;
    T* __restrict weight = weights + tap * count + first;
    for (int64_t i = 0; i < reached; ++i) weight[i] *= inverse[first + i];
    if (probabilities != nullptr)
      std::copy_n(weight, reached, probabilities + (layer * shape.taps() + tap) * shape.plane() + source);
    for (int64_t c = 0; c < shape.channels; ++c) {
      const int64_t plane = (layer * shape.channels + c) * shape.plane();
      add_product(weight, values + plane + source, out + plane + at.y * shape.width + reach.begin, reached);
    }
  }
}

template <class T>
void splat_backward(const SplatShape& shape, const T* probabilities, const T* values, const T* out,
                    const T* out_gradient, const int32_t* argmax, T* logits_gradient, T* log_n_gradient,
                    T* values_gradient, T* scratch, int64_t y) {
  const int64_t width = shape.width, row = y * width;
  T* __restrict pull = scratch;             // gradient of the exponent at one tap
  T* __restrict maximum = scratch + width;  // gradient of m_p
  std::fill_n(maximum, width, T(0));
  for (int64_t l = 0; l < shape.layers; ++l) {
    T* __restrict n_gradient = log_n_gradient + l * shape.plane() + row;
    std::fill_n(n_gradient, width, T(0));
    for (int64_t c = 0; c < shape.channels; ++c)
      std::fill_n(values_gradient + (l * shape.channels + c) * shape.plane() + row, width, T(0));
    for (int64_t tap = 0; tap < shape.taps(); ++tap) {
      T* __restrict gradient = logits_gradient + (l * shape.taps() + tap) * shape.plane() + row;
      const Reach reach = leaving(shape, tap, y);
      if (reach.empty() || reach.end - reach.begin < width) std::fill_n(gradient, width, T(0));
      if (reach.empty()) continue;
      const int64_t begin = reach.begin, count = reach.end - reach.begin;
      const int64_t destination = reach.row * width + begin + reach.dx;
      const T* __restrict p = probabilities + (l * shape.taps() + tap) * shape.plane() + row + begin;
      std::fill_n(pull, count, T(0));
      for (int64_t c = 0; c < shape.channels; ++c) {
        const int64_t plane = (l * shape.channels + c) * shape.plane();
        const T* __restrict g = out_gradient + plane + destination;
        const T* __restrict o = out + plane + destination;
        const T* __restrict v = values + plane + row + begin;
        T* __restrict v_gradient = values_gradient + plane + row + begin;
        for (int64_t i = 0; i < count; ++i) {
          // The probability first: a value of 3e38 that has none must give 0, not 0 * infinity.
          pull[i] += g[i] * (p[i] * (v[i] - o[i]));
          v_gradient[i] += p[i] * g[i];
        }
      }
      for (int64_t i = 0; i < count; ++i) {
        const T u = pull[i];
        gradient[begin + i] = u;
        n_gradient[begin + i] += u;
        maximum[begin + i] -= u;
      }
    }
  }
  for (int64_t x = 0; x < width; ++x)
    logits_gradient[argmax[row + x] * shape.plane() + row + x] += maximum[x];
}

#define LD_INSTANTIATE(T)                                                                                 \
  template void splat_maximum(const SplatShape&, const T*, T*, int32_t*, const Stretch&);                 \
  template void splat_exponents(const SplatShape&, int64_t, const T*, const T*, const T*, T*, T*,         \
                                const Stretch&);                                                          \
  template void splat_values(const SplatShape&, int64_t, T*, const T*, T*, T*, T*, const Stretch&);       \
  template void splat_backward(const SplatShape&, const T*, const T*, const T*, const T*, const int32_t*, \
                               T*, T*, T*, T*, int64_t);
LD_INSTANTIATE(float)
LD_INSTANTIATE(double)
#undef LD_INSTANTIATE

}  // namespace ld
