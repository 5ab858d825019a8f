#include "ops/kernels/quantised_convolution.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "core/error.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ops/kernels/quantised_convolution.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "ops/kernels/vectors-inl.h"

#ifndef LD_QUANTISED_LAYOUT
#define LD_QUANTISED_LAYOUT
namespace ld {

// A scratch of int32: what was quantised of a stretch, two channels side by side, even and odd columns apart;
// its B^T d B [16][pairs][kMostTiles]; the sums of a block of outputs [16][kBlock][kMostTiles].
constexpr int64_t kMostTiles = kWinogradPixels / 2;
constexpr int64_t kColumns = kMostTiles + kPixelStep;
constexpr int64_t kQuantisedPair = int64_t{4} * 2 * kColumns;

}  // namespace ld
#endif

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

using DI = hn::RebindToSigned<D>;  // sums, or two numbers of 16 bits
using VI = hn::Vec<DI>;

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE VI two_numbers(int first, int second) {
  return hn::Set(DI(), int32_t((uint32_t(second) << 16) | (uint32_t(first) & 0xffff)));
}
HWY_INLINE int first_of(VI x) {
  return int16_t(hn::GetLane(x) & 0xffff);
}
HWY_INLINE int second_of(VI x) {
  return hn::GetLane(x) >> 16;
}
HWY_INLINE VI add_two(VI a, VI b) {
  return two_numbers(first_of(a) + first_of(b), second_of(a) + second_of(b));
}
HWY_INLINE VI subtract_two(VI a, VI b) {
  return two_numbers(first_of(a) - first_of(b), second_of(a) - second_of(b));
}
/// sum += the products of both numbers.
HWY_INLINE VI add_products(VI sum, VI a, VI b) {
  const int products = first_of(a) * first_of(b) + second_of(a) * second_of(b);
  return hn::Set(DI(), int32_t(uint32_t(hn::GetLane(sum)) + uint32_t(products)));
}
#else
using DS = hn::Repartition<int16_t, D>;
HWY_INLINE VI add_two(VI a, VI b) {
  return hn::BitCast(DI(), hn::Add(hn::BitCast(DS(), a), hn::BitCast(DS(), b)));
}
HWY_INLINE VI subtract_two(VI a, VI b) {
  return hn::BitCast(DI(), hn::Sub(hn::BitCast(DS(), a), hn::BitCast(DS(), b)));
}
HWY_INLINE VI add_products(VI sum, VI a, VI b) {
  VI rest = hn::Zero(DI());  // of processors whose products come in two parts
  const VI part =
      hn::ReorderWidenMulAccumulate(DI(), hn::BitCast(DS(), a), hn::BitCast(DS(), b), hn::Zero(DI()), rest);
  return hn::Add(sum, hn::RearrangeToOddPlusEven(part, rest));
}
#endif

/// Of activations.
struct Levels {
  float per_unit, most;
};
HWY_INLINE VI in_levels(const float* from, Levels levels) {
  const D d;
  const V scaled = hn::Mul(hn::LoadU(d, from), hn::Set(d, levels.per_unit));
  return hn::NearestInt(hn::Min(hn::Max(scaled, hn::Set(d, -levels.most)), hn::Set(d, levels.most)));
}

/// Two channels side by side: `second` may be null.
HWY_INLINE VI pair_in_levels(const float* first, const float* second, Levels levels) {
  const DI di;
  const VI low = hn::And(in_levels(first, levels), hn::Set(di, 0xffff));
  return second == nullptr ? low : hn::Or(low, hn::ShiftLeft<16>(in_levels(second, levels)));
}

/// Columns begin - 1, begin, ... of a row of two channels: even ones to[0 ..], odd ones to[kColumns ..].
HWY_INLINE void quantise_row(const float* first, const float* second, Levels levels, int64_t columns,
                             int32_t* HWY_RESTRICT to) {
  const DI di;
  for (int64_t t = 0; t < columns; t += lanes()) {
    const int64_t x = 2 * t, next = x + lanes();
    const VI a = pair_in_levels(first + x, second == nullptr ? nullptr : second + x, levels);
    const VI b = pair_in_levels(first + next, second == nullptr ? nullptr : second + next, levels);
#if HWY_TARGET == HWY_SCALAR
    hn::Store(a, di, to + t);
    hn::Store(b, di, to + kColumns + t);
#else
    hn::Store(hn::ConcatEven(di, b, a), di, to + t);
    hn::Store(hn::ConcatOdd(di, b, a), di, to + kColumns + t);
#endif
  }
}

/// B^T d of four numbers, two channels at once.
HWY_INLINE void input_transform(VI (&d)[4]) {
  const VI first = subtract_two(d[0], d[2]), second = add_two(d[1], d[2]), third = subtract_two(d[2], d[1]);
  d[3] = subtract_two(d[1], d[3]);
  d[0] = first;
  d[1] = second;
  d[2] = third;
}

/// B^T d B of two channels.
HWY_INLINE void transform_pair(const int32_t* HWY_RESTRICT from, int64_t tiles, int32_t* HWY_RESTRICT to,
                               int64_t stride) {
  const DI di;
  for (int64_t t = 0; t < tiles; t += lanes()) {
    VI v[4][4];  // [column][row]
#pragma GCC unroll 4
    for (int y = 0; y < 4; ++y) {
      const int32_t* even = from + 2 * y * kColumns + t;
      const int32_t* odd = even + kColumns;
      v[0][y] = hn::Load(di, even);
      v[1][y] = hn::Load(di, odd);
      v[2][y] = hn::LoadU(di, even + 1);
      v[3][y] = hn::LoadU(di, odd + 1);
    }
#pragma GCC unroll 4
    for (int x = 0; x < 4; ++x) input_transform(v[x]);
#pragma GCC unroll 4
    for (int y = 0; y < 4; ++y) {
      VI across[4] = {v[0][y], v[1][y], v[2][y], v[3][y]};
      input_transform(across);
#pragma GCC unroll 4
      for (int x = 0; x < 4; ++x) hn::Store(across[x], di, to + (4 * y + x) * stride + t);
    }
  }
}

void transform_quantised(const QuantisedRows& rows, int64_t tiles, int32_t* quantised, int32_t* to) {
  const PackedQuantisedWeights& weights = *rows.weights;
  const int64_t columns = (rows.end - rows.begin + 1) / 2 + 1;
  struct Channel {
    const WinogradSource* source;
    int64_t channel;
    const float* row(size_t y, int64_t x) const {
      return source->rows[y].data + channel * source->rows[y].pitch + x;
    }
  };
  std::vector<Channel> channels;
  for (const WinogradSource& source : rows.sources)
    for (int64_t c = 0; c < source.channels; ++c) channels.push_back({&source, c});
  for (int64_t i = 0; i < weights.pairs; ++i) {
    const bool both = 2 * i + 1 < weights.inputs;
    for (size_t y = 0; y < 4; ++y)
      quantise_row(channels[size_t(2 * i)].row(y, rows.begin - 1),
                   both ? channels[size_t(2 * i + 1)].row(y, rows.begin - 1) : nullptr,
                   {weights.levels_per_unit, weights.levels}, columns, quantised + int64_t(y) * 2 * kColumns);
    transform_pair(quantised, tiles, to + i * tiles, weights.pairs * tiles);
  }
}

/// Outputs [o, o + kMr) of matrix m, kNv vectors of tiles from t.
template <int kMr, int kNv>
HWY_INLINE void product_block(const PackedQuantisedWeights& weights, int64_t m, int64_t o, int64_t t,
                              int64_t tiles, const int32_t* HWY_RESTRICT in, int32_t* HWY_RESTRICT out) {
  const DI di;
  const int32_t* HWY_RESTRICT w = weights.block(m, o) + o % PackedQuantisedWeights::kBlock;
  in += t;
  VI sum[kMr][kNv];
#pragma GCC unroll 8
  for (int r = 0; r < kMr; ++r)
#pragma GCC unroll 3
    for (int v = 0; v < kNv; ++v) sum[r][v] = hn::Zero(di);
  for (int64_t i = 0; i < weights.pairs; ++i) {
    VI x[kNv];
#pragma GCC unroll 3
    for (int v = 0; v < kNv; ++v) x[v] = hn::Load(di, in + v * lanes());
#pragma GCC unroll 8
    for (int r = 0; r < kMr; ++r) {
      const VI weight = hn::Set(di, w[r]);
#pragma GCC unroll 3
      for (int v = 0; v < kNv; ++v) sum[r][v] = add_products(sum[r][v], weight, x[v]);
    }
    w += PackedQuantisedWeights::kBlock;
    in += tiles;
  }
#pragma GCC unroll 8
  for (int r = 0; r < kMr; ++r)
#pragma GCC unroll 3
    for (int v = 0; v < kNv; ++v) hn::Store(sum[r][v], di, out + r * kMostTiles + t + v * lanes());
}

/// A^T m of four numbers.
struct SumPair {
  VI first, second;
};
HWY_INLINE SumPair output_transform(VI a, VI b, VI c, VI d) {
  return {hn::Add(hn::Add(a, b), c), hn::Sub(hn::Sub(b, c), d)};
}

/// Two neighbours of each lane's tile, as far as the stretch goes.
HWY_INLINE void store_quantised(D d, V first, V second, float* to, int64_t left) {
  if (left >= 2 * lanes()) return hn::StoreInterleaved2(first, second, d, to);
  HWY_ALIGN float pixels[size_t{2} * HWY_MAX_BYTES / sizeof(float)];
  hn::StoreInterleaved2(first, second, d, pixels);
  std::copy_n(pixels, std::max<int64_t>(left, 0), to);
}

HWY_INLINE void transform_sums(const QuantisedRows& rows, int64_t o, int64_t tiles, const int32_t* sums) {
  const D d;
  const DI di;
  const V scale = hn::Set(d, rows.weights->scales[size_t(o)]),
          bias = hn::Set(d, rows.weights->biases[size_t(o)]);
  constexpr int64_t kStride = PackedQuantisedWeights::kBlock * kMostTiles;
  for (int64_t t = 0; t < tiles; t += lanes()) {
    const int32_t* m = sums + t;
    SumPair down[4];
#pragma GCC unroll 4
    for (int x = 0; x < 4; ++x)
      down[x] = output_transform(hn::Load(di, m + x * kStride), hn::Load(di, m + (4 + x) * kStride),
                                 hn::Load(di, m + (8 + x) * kStride), hn::Load(di, m + (12 + x) * kStride));
    const SumPair result[2] = {
        output_transform(down[0].first, down[1].first, down[2].first, down[3].first),
        output_transform(down[0].second, down[1].second, down[2].second, down[3].second)};
#pragma GCC unroll 2
    for (int y = 0; y < 2; ++y) {
      if (rows.out[size_t(y)] == nullptr) continue;
      V first = hn::MulAdd(hn::ConvertTo(d, result[y].first), scale, bias);
      V second = hn::MulAdd(hn::ConvertTo(d, result[y].second), scale, bias);
      if (rows.slope != 1)
        first = leaky_relu(d, first, rows.slope), second = leaky_relu(d, second, rows.slope);
      const int64_t x = rows.begin + 2 * t;
      store_quantised(d, first, second, rows.out[size_t(y)] + o * rows.out_pitch + x, rows.end - x);
    }
  }
}

void convolve_quantised(const QuantisedRows& rows, int32_t* scratch) {
  const PackedQuantisedWeights& weights = *rows.weights;
  const int64_t needed = (rows.end - rows.begin + 1) / 2, tiles = (needed + lanes() - 1) / lanes() * lanes();
  int32_t* inputs = scratch + kQuantisedPair;
  int32_t* sums = inputs + 16 * weights.pairs * kMostTiles;
  transform_quantised(rows, tiles, scratch, inputs);
  for (int64_t block = 0; block < weights.outputs; block += PackedQuantisedWeights::kBlock) {
    const int64_t count = std::min(PackedQuantisedWeights::kBlock, weights.outputs - block);
    for (int64_t m = 0; m < 16; ++m) {
      const int32_t* in = inputs + m * weights.pairs * tiles;
      int32_t* out = sums + m * PackedQuantisedWeights::kBlock * kMostTiles;
      const auto panel = [&](auto vectors, int64_t t) {
        in_blocks(count, [&](auto number, int64_t o) {
          product_block<decltype(number)::value, decltype(vectors)::value>(weights, m, block + o, t, tiles,
                                                                           in, out + o * kMostTiles);
        });
      };
      int64_t t = 0;
      for (; t + kVectors * lanes() <= tiles; t += kVectors * lanes())
        panel(std::integral_constant<int, kVectors>(), t);
      for (; t < tiles; t += lanes()) panel(std::integral_constant<int, 1>(), t);
    }
    for (int64_t o = 0; o < count; ++o) transform_sums(rows, block + o, tiles, sums + o * kMostTiles);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(convolve_quantised);

int activation_levels(const QuantisedWeights& weights) {
  int64_t largest = 1;  // sum of an output's weights, without their signs
  const int64_t row = weights.inputs * 9;
  for (int64_t o = 0; o < weights.outputs; ++o) {
    int64_t sum = 0;
    for (int64_t i = 0; i < row; ++i) sum += std::abs(int(weights.values[o * row + i]));
    largest = std::max(largest, sum);
  }
  constexpr int64_t kMostSum = (int64_t{1} << 31) - 1;
  const int64_t levels = std::min<int64_t>(kMostLevel, kMostSum / 4 / largest);
  if (levels < 1)
    fail("a quantised convolution of {} inputs, whose sums could leave 32 bits; export with --dtype f16",
         weights.inputs);
  return int(levels);
}

PackedQuantisedWeights::PackedQuantisedWeights(const QuantisedWeights& weights, float range)
    : outputs(weights.outputs),
      inputs(weights.inputs),
      pairs((inputs + 1) / 2),
      levels(float(activation_levels(weights))),
      levels_per_unit(levels / range),
      biases(weights.biases, weights.biases + outputs),
      blocks_((outputs + kBlock - 1) / kBlock) {
  for (int64_t o = 0; o < outputs; ++o) scales.push_back(weights.scales[o] / levels_per_unit / 4);
  pairs_ = hwy::AllocateAligned<int32_t>(size_t(16 * blocks_ * kBlock * pairs));
  std::fill_n(pairs_.get(), 16 * blocks_ * kBlock * pairs, 0);
  constexpr int kG[4][3] = {{2, 0, 0}, {1, 1, 1}, {1, -1, 1}, {0, 0, 2}};
  for (int64_t m = 0; m < 16; ++m)
    for (int64_t o = 0; o < outputs; ++o)
      for (int64_t i = 0; i < inputs; ++i) {
        const int8_t* g = weights.values + (o * inputs + i) * 9;
        int sum = 0;
        for (int y = 0; y < 3; ++y)
          for (int x = 0; x < 3; ++x) sum += kG[m / 4][y] * kG[m % 4][x] * g[3 * y + x];
        const int64_t at =
            ((m * blocks_ * kBlock + o / kBlock * kBlock) * pairs) + i / 2 * kBlock + o % kBlock;
        pairs_[size_t(at)] |= i % 2 == 0 ? sum & 0xffff : int32_t(uint32_t(sum) << 16);
      }
}

int64_t QuantisedScratch::bytes(const PackedQuantisedWeights& weights) {
  const int64_t numbers = kQuantisedPair + 16 * kMostTiles * (weights.pairs + PackedQuantisedWeights::kBlock);
  return numbers * int64_t(sizeof(int32_t));
}
QuantisedScratch::QuantisedScratch(const PackedQuantisedWeights& weights)
    : memory(hwy::AllocateAligned<int32_t>(size_t(bytes(weights)) / sizeof(int32_t))) {
  std::memset(memory.get(), 0, size_t(bytes(weights)));
}

void convolve(const QuantisedRows& rows, QuantisedScratch& scratch) {
  HWY_DYNAMIC_DISPATCH(convolve_quantised)(rows, scratch.memory.get());
  rows.clear_tail();
}

}  // namespace ld
#endif
