// Inner loops of weighted_sum over one picture, free of LibTorch. Planes of `plane` contiguous pixels; a call
// takes the pixels [begin, end). T is float or double.
#pragma once

#include <cstdint>
#include <limits>

namespace ld {

struct SumShape {
  int64_t samples, layers, channels, plane;
};

/// Bound of a product in the gradient of the weights. A gradient times a radiance of 3e38 may overflow
/// although the weight's own derivative, with which it is multiplied next, is 0: the product must stay
/// finite, or that is NaN. Room for the sum over 8192 channels.
template <class T>
constexpr T kLargestTerm = std::numeric_limits<T>::max() / 8192;

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
