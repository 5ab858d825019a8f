// Inner loops of weighted_sum over one picture, free of LibTorch. Planes of `plane` contiguous pixels; a call
// takes the pixels [begin, end). T is float or double.
#pragma once

#include <cstdint>

namespace ld {

struct SumShape {
  int64_t samples, layers, channels, plane;
};

/// out[l][c][p] = sum over s of weights[s][l][p] * values[s][c][p].
template <class T>
void sum_samples(const SumShape& shape, const T* weights, const T* values, T* out, int64_t begin,
                 int64_t end);

/// weights_gradient[s][l][p] = sum over c of gradient[l][c][p] * values[s][c][p], each product bounded to
/// stay finite.
template <class T>
void sum_samples_weights_gradient(const SumShape& shape, const T* gradient, const T* values,
                                  T* weights_gradient, int64_t begin, int64_t end);

/// values_gradient[s][c][p] = sum over l of weights[s][l][p] * gradient[l][c][p].
template <class T>
void sum_samples_values_gradient(const SumShape& shape, const T* gradient, const T* weights,
                                 T* values_gradient, int64_t begin, int64_t end);

}  // namespace ld
