#include "ops/kernels/convolution.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ops/kernels/convolution.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Behind them, or it is there for one instruction set alone.
#include <hwy/contrib/math/math-inl.h>

#include "ops/kernels/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

HWY_INLINE V activated(D d, Activation activation, float slope, V x) {
  if (activation == Activation::leaky_relu) return leaky_relu(d, x, slope);
  if (activation == Activation::relu) return hn::Max(x, hn::Zero(d));
  return hn::Tanh(d, x);
}

/// Outputs [o, o + kMr), kNv vectors of pixels from x.
template <int kMr, int kNv, int kKernel>
HWY_INLINE void convolve_block(const ConvolutionRow& t, int64_t o, int64_t x) {
  const D d;
  const float* HWY_RESTRICT w = t.weights->block(o) + o % PackedConvolution::kBlock;
  V sum[kMr][kNv];
#pragma GCC unroll 8
  for (int r = 0; r < kMr; ++r)
#pragma GCC unroll 3
    for (int v = 0; v < kNv; ++v) sum[r][v] = hn::Set(d, t.weights->biases()[o + r]);
  for (const ConvolutionSource& source : t.sources)
    for (int64_t c = 0; c < source.channels; ++c)
      for (int dy = 0; dy < kKernel; ++dy) {
        const PlanarRow& row = source.rows[dy];
        const float* HWY_RESTRICT in = row.data + c * row.pitch + x - kKernel / 2;
#pragma GCC unroll 5
        for (int dx = 0; dx < kKernel; ++dx) {
          V pixels[kNv];
#pragma GCC unroll 3
          for (int v = 0; v < kNv; ++v) pixels[v] = hn::LoadU(d, in + dx + v * lanes());
#pragma GCC unroll 8
          for (int r = 0; r < kMr; ++r) {
            const V weight = hn::Set(d, w[r]);
#pragma GCC unroll 3
            for (int v = 0; v < kNv; ++v) sum[r][v] = hn::MulAdd(weight, pixels[v], sum[r][v]);
          }
          w += PackedConvolution::kBlock;
        }
      }
#pragma GCC unroll 8
  for (int r = 0; r < kMr; ++r)
#pragma GCC unroll 3
    for (int v = 0; v < kNv; ++v) {
      V result = sum[r][v];
      if (t.activation != Activation::none) result = activated(d, t.activation, t.slope, result);
      hn::Store(result, d, t.out + (o + r) * t.out_pitch + x + v * lanes());
    }
}

template <int kNv, int kKernel>
HWY_INLINE void convolve_pixels(const ConvolutionRow& t, int64_t x) {
  in_blocks(t.weights->outputs,
            [&](auto number, int64_t o) { convolve_block<decltype(number)::value, kNv, kKernel>(t, o, x); });
}

template <int kKernel>
HWY_INLINE void convolve_with(const ConvolutionRow& t) {
  int64_t x = t.begin;
  for (; x + kVectors * lanes() <= t.end; x += kVectors * lanes()) convolve_pixels<kVectors, kKernel>(t, x);
  for (; x < t.end; x += lanes()) convolve_pixels<1, kKernel>(t, x);
}

void convolve_row(const ConvolutionRow& t) {
  if (t.weights->kernel == 5)
    convolve_with<5>(t);
  else
    convolve_with<3>(t);
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(convolve_row);

PackedConvolution::PackedConvolution(const float* weights, const float* biases, int64_t outputs_in,
                                     int64_t inputs_in, int64_t kernel_in)
    : outputs(outputs_in), inputs(inputs_in), kernel(kernel_in), biases_(biases, biases + outputs_in) {
  const int64_t taps = inputs * kernel * kernel, blocks = (outputs + kBlock - 1) / kBlock;
  data_ = hwy::AllocateAligned<float>(size_t(blocks * kBlock * taps));
  std::fill_n(data_.get(), blocks * kBlock * taps, 0.0f);
  for (int64_t o = 0; o < outputs; ++o)
    for (int64_t tap = 0; tap < taps; ++tap)
      data_[size_t(o / kBlock * kBlock * taps + tap * kBlock + o % kBlock)] = weights[o * taps + tap];
}

void convolve(const ConvolutionRow& row) {
  HWY_DYNAMIC_DISPATCH(convolve_row)(row);
  // Zeros again where the next convolution takes what it reads for the border.
  const int64_t first = std::max(row.begin, row.width);
  if (row.end <= first) return;
  for (int64_t o = 0; o < row.weights->outputs; ++o)
    std::fill(row.out + o * row.out_pitch + first, row.out + o * row.out_pitch + row.end, 0.0f);
}

}  // namespace ld
#endif
