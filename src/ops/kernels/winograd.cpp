#include "ops/kernels/winograd.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ops/kernels/winograd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "ops/kernels/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

/// B^T d of four numbers.
HWY_INLINE void input_transform(V (&d)[4]) {
  const V first = hn::Sub(d[0], d[2]), second = hn::Add(d[1], d[2]), third = hn::Sub(d[2], d[1]);
  d[3] = hn::Sub(d[1], d[3]);
  d[0] = first;
  d[1] = second;
  d[2] = third;
}

/// A^T m of four numbers.
struct Pair {
  V first, second;
};
HWY_INLINE Pair output_transform(V a, V b, V c, V d) {
  return {hn::Add(hn::Add(a, b), c), hn::Sub(hn::Sub(b, c), d)};
}

/// B^T d B of one channel: to[16], `stride` floats apart, a number for each tile.
HWY_INLINE void transform_channel(const std::array<PlanarRow, 4>& rows, int64_t channel, int64_t begin,
                                  int64_t tiles, float* HWY_RESTRICT to, int64_t stride) {
  const D d;
  for (int64_t t = 0; t < tiles; t += lanes()) {
    V v[4][4];  // [column][row]: the column's numbers are transformed first
#pragma GCC unroll 4
    for (int y = 0; y < 4; ++y) {
      const PlanarRow& row = rows[size_t(y)];
      const float* from = row.data + channel * row.pitch + begin - 1 + 2 * t;
      hn::LoadInterleaved2(d, from, v[0][y], v[1][y]);
      hn::LoadInterleaved2(d, from + 2, v[2][y], v[3][y]);
    }
#pragma GCC unroll 4
    for (int x = 0; x < 4; ++x) input_transform(v[x]);
#pragma GCC unroll 4
    for (int y = 0; y < 4; ++y) {
      V across[4] = {v[0][y], v[1][y], v[2][y], v[3][y]};
      input_transform(across);
#pragma GCC unroll 4
      for (int x = 0; x < 4; ++x) hn::Store(across[x], d, to + (4 * y + x) * stride + t);
    }
  }
}

void transform_inputs(const WinogradRows& rows, int64_t tiles, float* to) {
  int64_t i = 0;
  for (const WinogradSource& source : rows.sources)
    for (int64_t c = 0; c < source.channels; ++c, ++i)
      transform_channel(source.rows, c, rows.begin, tiles, to + i * tiles, rows.weights->inputs * tiles);
}

/// Two neighbours of each lane's tile, as far as the stretch goes.
HWY_INLINE void store_pixels(D d, Pair result, float* to, int64_t left) {
  if (left >= 2 * lanes()) return hn::StoreInterleaved2(result.first, result.second, d, to);
  HWY_ALIGN float pixels[size_t{2} * HWY_MAX_BYTES / sizeof(float)];
  hn::StoreInterleaved2(result.first, result.second, d, pixels);
  std::copy_n(pixels, std::max<int64_t>(left, 0), to);
}

void transform_outputs(const WinogradRows& rows, int64_t tiles, const float* products) {
  const D d;
  const int64_t stride = rows.weights->outputs * tiles;
  for (int64_t o = 0; o < rows.weights->outputs; ++o) {
    const V bias = hn::Set(d, rows.weights->biases[size_t(o)]);
    for (int64_t t = 0; t < tiles; t += lanes()) {
      const float* m = products + o * tiles + t;
      Pair down[4];
#pragma GCC unroll 4
      for (int x = 0; x < 4; ++x)
        down[x] = output_transform(hn::Load(d, m + x * stride), hn::Load(d, m + (4 + x) * stride),
                                   hn::Load(d, m + (8 + x) * stride), hn::Load(d, m + (12 + x) * stride));
      const Pair result[2] = {
          output_transform(down[0].first, down[1].first, down[2].first, down[3].first),
          output_transform(down[0].second, down[1].second, down[2].second, down[3].second)};
#pragma GCC unroll 2
      for (int y = 0; y < 2; ++y) {
        if (rows.out[size_t(y)] == nullptr) continue;
        Pair pixels = {hn::Add(result[y].first, bias), hn::Add(result[y].second, bias)};
        if (rows.slope != 1)
          pixels = {leaky_relu(d, pixels.first, rows.slope), leaky_relu(d, pixels.second, rows.slope)};
        const int64_t x = rows.begin + 2 * t;
        store_pixels(d, pixels, rows.out[size_t(y)] + o * rows.out_pitch + x, rows.end - x);
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(transform_inputs);
HWY_EXPORT(transform_outputs);

WinogradWeights::WinogradWeights(const float* weights, const float* biases_in, int64_t outputs_in,
                                 int64_t inputs_in)
    : outputs(outputs_in), inputs(inputs_in), biases(biases_in, biases_in + outputs_in) {
  constexpr double kG[4][3] = {{1, 0, 0}, {0.5, 0.5, 0.5}, {0.5, -0.5, 0.5}, {0, 0, 1}};
  std::vector<float> matrix(size_t(outputs * inputs));
  for (const auto& down : kG)
    for (const auto& across : kG) {
      for (size_t i = 0; i < matrix.size(); ++i) {
        double sum = 0;
        for (size_t y = 0; y < 3; ++y)
          for (size_t x = 0; x < 3; ++x) sum += down[y] * across[x] * double(weights[i * 9 + y * 3 + x]);
        matrix[i] = float(sum);
      }
      matrices.emplace_back(matrix.data(), outputs, inputs, inputs, 1);
    }
}

WinogradScratch::WinogradScratch(const WinogradWeights& weights)
    : inputs(hwy::AllocateAligned<float>(size_t(8 * kWinogradPixels * weights.inputs))),
      products(hwy::AllocateAligned<float>(size_t(8 * kWinogradPixels * weights.outputs))) {}

void convolve(const WinogradRows& rows, WinogradScratch& scratch) {
  const WinogradWeights& weights = *rows.weights;
  const int64_t tiles = padded((rows.end - rows.begin + 1) / 2);
  HWY_DYNAMIC_DISPATCH(transform_inputs)(rows, tiles, scratch.inputs.get());
  for (size_t i = 0; i < weights.matrices.size(); ++i) {
    TileProduct product;
    product.weights = &weights.matrices[i];
    product.in = scratch.inputs.get() + int64_t(i) * weights.inputs * tiles;
    product.in_pitch = tiles;
    product.out = scratch.products.get() + int64_t(i) * weights.outputs * tiles;
    product.out_pitch = tiles;
    product.pixels = tiles;
    multiply(product);
  }
  HWY_DYNAMIC_DISPATCH(transform_outputs)(rows, tiles, scratch.products.get());
  rows.clear_tail();
}

}  // namespace ld
#endif
