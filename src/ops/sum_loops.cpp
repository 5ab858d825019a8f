#include "ops/sum_loops.h"

#include <algorithm>

namespace ld {
namespace {

/// out += a * b over `count` pixels; the planes never overlap.
template <class T>
void add_product(const T* __restrict a, const T* __restrict b, T* __restrict out, int64_t count) {
  for (int64_t i = 0; i < count; ++i) out[i] += a[i] * b[i];
}

template <class T>
void add_bounded_product(const T* __restrict a, const T* __restrict b, T* __restrict out, int64_t count) {
  for (int64_t i = 0; i < count; ++i) {
    const T product = a[i] * b[i];
    const T below = product < kLargestTerm<T> ? product : kLargestTerm<T>;
    out[i] += below > -kLargestTerm<T> ? below : -kLargestTerm<T>;
  }
}

}  // namespace

template <class T>
void sum_samples(const SumShape& shape, const T* weights, const T* values, T* out, int64_t begin,
                 int64_t end) {
  const int64_t count = end - begin;
  for (int64_t l = 0; l < shape.layers; ++l)
    for (int64_t c = 0; c < shape.channels; ++c) {
      T* row = out + (l * shape.channels + c) * shape.plane + begin;
      std::fill_n(row, count, T(0));
      for (int64_t s = 0; s < shape.samples; ++s)
        add_product(weights + (s * shape.layers + l) * shape.plane + begin,
                    values + (s * shape.channels + c) * shape.plane + begin, row, count);
    }
}

template <class T>
void sum_samples_weights_gradient(const SumShape& shape, const T* gradient, const T* values,
                                  T* weights_gradient, int64_t begin, int64_t end) {
  const int64_t count = end - begin;
  for (int64_t s = 0; s < shape.samples; ++s)
    for (int64_t l = 0; l < shape.layers; ++l) {
      T* row = weights_gradient + (s * shape.layers + l) * shape.plane + begin;
      std::fill_n(row, count, T(0));
      for (int64_t c = 0; c < shape.channels; ++c)
        add_bounded_product(gradient + (l * shape.channels + c) * shape.plane + begin,
                            values + (s * shape.channels + c) * shape.plane + begin, row, count);
    }
}

template <class T>
void sum_samples_values_gradient(const SumShape& shape, const T* gradient, const T* weights,
                                 T* values_gradient, int64_t begin, int64_t end) {
  const int64_t count = end - begin;
  for (int64_t s = 0; s < shape.samples; ++s)
    for (int64_t c = 0; c < shape.channels; ++c) {
      T* row = values_gradient + (s * shape.channels + c) * shape.plane + begin;
      std::fill_n(row, count, T(0));
      for (int64_t l = 0; l < shape.layers; ++l)
        add_product(weights + (s * shape.layers + l) * shape.plane + begin,
                    gradient + (l * shape.channels + c) * shape.plane + begin, row, count);
    }
}

template void sum_samples(const SumShape&, const float*, const float*, float*, int64_t, int64_t);
template void sum_samples(const SumShape&, const double*, const double*, double*, int64_t, int64_t);
template void sum_samples_weights_gradient(const SumShape&, const float*, const float*, float*, int64_t,
                                           int64_t);
template void sum_samples_weights_gradient(const SumShape&, const double*, const double*, double*, int64_t,
                                           int64_t);
template void sum_samples_values_gradient(const SumShape&, const float*, const float*, float*, int64_t,
                                          int64_t);
template void sum_samples_values_gradient(const SumShape&, const double*, const double*, double*, int64_t,
                                          int64_t);

}  // namespace ld
