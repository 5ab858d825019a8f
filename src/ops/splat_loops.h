// Inner loops of kernel_splat over one picture, free of LibTorch: rows of planar, contiguous arrays
//   logits, probabilities [N][K*K][H][W], log_n [N][H][W], values and results [N][C][H][W], maximum, argmax
//   [H][W].
// T is float or double. Loops over x are innermost and without branches, so that compilers vectorise them.
#pragma once

#include <cstdint>

namespace ld {

struct SplatShape {
  int64_t layers, kernel, channels, height, width;
  int64_t taps() const { return kernel * kernel; }
  int64_t plane() const { return height * width; }
};

/// A stretch of a row: pixels [begin, end) of row y.
struct Stretch {
  int64_t y, begin, end;
  int64_t count() const { return end - begin; }
};

/// m_p, the largest logit over taps and layers, and the first plane (layer * taps + tap) that holds it.
template <class T>
void splat_maximum(const SplatShape& shape, const T* logits, T* maximum, int32_t* argmax, const Stretch& at);

/// exponents[tap][i] = e_l + log n_l - M of what arrives at the stretch's pixel i by that tap (M the largest,
/// so that the largest becomes 0); -inf where nothing arrives or exp() would be below the smallest normal
/// number. `largest` is scratch of the stretch's size.
template <class T>
void splat_exponents(const SplatShape& shape, int64_t layer, const T* logits, const T* maximum,
                     const T* log_n, T* exponents, T* largest, const Stretch& at);

/// weights[tap][i] = exp(exponents): normalises them, and sums the values that they bring into out. Where
/// `probabilities` is not null, writes them there at their source, for the backward pass. `total` is scratch.
template <class T>
void splat_values(const SplatShape& shape, int64_t layer, T* weights, const T* values, T* probabilities,
                  T* out, T* total, const Stretch& at);

/// One row of sources, all layers: the gradients of logits, log_n and values from that of the result.
/// `scratch` holds 2 * width numbers.
template <class T>
void splat_backward(const SplatShape& shape, const T* probabilities, const T* values, const T* out,
                    const T* out_gradient, const int32_t* argmax, T* logits_gradient, T* log_n_gradient,
                    T* values_gradient, T* scratch, int64_t y);

}  // namespace ld
