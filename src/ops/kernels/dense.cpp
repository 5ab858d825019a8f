#include "ops/kernels/dense.h"

#include <hwy/cache_control.h>

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ops/kernels/dense.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "ops/kernels/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

/// c x / (c + |x|), in a form that an infinite x does not break.
HWY_INLINE V bounded(D d, V x, V bound) {
  const V rest = hn::Div(bound, hn::Add(bound, hn::Abs(x)));
  return hn::CopySign(hn::Mul(bound, hn::Sub(hn::Set(d, 1.0f), rest)), x);
}

/// What becomes of a vector of sums. A choice for each vector at run time would cost a quarter of the time of
/// a layer of 32 inputs.
template <Epilogue kEpilogue>
HWY_INLINE V finished(D d, const TileProduct& t, V sum, int64_t row, int64_t column) {
  if constexpr (kEpilogue == Epilogue::leaky_relu) return leaky_relu(d, sum);
  if constexpr (kEpilogue == Epilogue::bounded) return bounded(d, sum, hn::Set(d, t.bound));
  if constexpr (kEpilogue == Epilogue::leaky_relu_backward) {
    const V a = hn::Load(d, t.activated + row * t.activated_pitch + column);
    return hn::IfThenElse(hn::Gt(a, hn::Zero(d)), sum, hn::Mul(sum, hn::Set(d, float(kLeakySlope))));
  }
  return sum;
}

/// Rows [row, row + kMr) of the product, kNv vectors of pixels from `column`.
template <Epilogue kEpilogue, int kMr, int kNv>
HWY_INLINE void product_block(const TileProduct& t, int64_t row, int64_t column) {
  const D d;
  const int64_t lanes = int64_t(hn::Lanes(d));
  const float* HWY_RESTRICT w = t.weights->block(row) + row % PackedWeights::kBlock;
  const float* HWY_RESTRICT in = t.in + column;
  V sum[kMr][kNv];
#pragma GCC unroll 8
  for (int r = 0; r < kMr; ++r)
#pragma GCC unroll 3
    for (int v = 0; v < kNv; ++v) sum[r][v] = t.bias != nullptr ? hn::Set(d, t.bias[row + r]) : hn::Zero(d);
  if (t.offset != nullptr)
#pragma GCC unroll 8
    for (int r = 0; r < kMr; ++r)
#pragma GCC unroll 3
      for (int v = 0; v < kNv; ++v)
        sum[r][v] =
            hn::Add(sum[r][v], hn::Load(d, t.offset + (row + r) * t.offset_pitch + column + v * lanes));
  const int64_t inputs = t.weights->inputs;
#pragma GCC unroll 4
  for (int64_t i = 0; i < inputs; ++i) {
    V x[kNv];
#pragma GCC unroll 3
    for (int v = 0; v < kNv; ++v) x[v] = hn::Load(d, in + v * lanes);
#pragma GCC unroll 8
    for (int r = 0; r < kMr; ++r) {
      const V weight = hn::Set(d, w[r]);
#pragma GCC unroll 3
      for (int v = 0; v < kNv; ++v) sum[r][v] = hn::MulAdd(weight, x[v], sum[r][v]);
    }
    w += PackedWeights::kBlock;
    in += t.in_pitch;
  }
#pragma GCC unroll 8
  for (int r = 0; r < kMr; ++r)
#pragma GCC unroll 3
    for (int v = 0; v < kNv; ++v) {
      const int64_t x = column + v * lanes;
      hn::Store(finished<kEpilogue>(d, t, sum[r][v], row + r, x), d, t.out + (row + r) * t.out_pitch + x);
    }
}

/// All rows, kNv vectors of pixels.
template <Epilogue kEpilogue, int kNv>
HWY_INLINE void product_panel(const TileProduct& t, int64_t column) {
  in_blocks(t.weights->outputs, [&](auto number, int64_t row) {
    product_block<kEpilogue, decltype(number)::value, kNv>(t, row, column);
  });
}

template <Epilogue kEpilogue>
void multiply_and_finish(const TileProduct& t) {
  const int64_t lanes = int64_t(hn::Lanes(D()));
  int64_t column = 0;
  for (; column + kVectors * lanes <= t.pixels; column += kVectors * lanes)
    product_panel<kEpilogue, kVectors>(t, column);
  for (; column < t.pixels; column += lanes) product_panel<kEpilogue, 1>(t, column);
}

void multiply_tile(const TileProduct& t) {
  switch (t.epilogue) {
    case Epilogue::none:
      return multiply_and_finish<Epilogue::none>(t);
    case Epilogue::leaky_relu:
      return multiply_and_finish<Epilogue::leaky_relu>(t);
    case Epilogue::bounded:
      return multiply_and_finish<Epilogue::bounded>(t);
    case Epilogue::leaky_relu_backward:
      return multiply_and_finish<Epilogue::leaky_relu_backward>(t);
  }
}

/// out[0 .. 4) += the sums of a, b, c and e over all lanes.
HWY_INLINE void add_sums_of_four(D d, V a, V b, V c, V e, float* out) {
#if HWY_TARGET == HWY_SCALAR
  (void)d;
  const V sums[4] = {a, b, c, e};
  for (int i = 0; i < 4; ++i) out[i] += hn::GetLane(sums[i]);
#else
  const hn::Repartition<double, D> pairs;
  const hn::FixedTag<float, 4> four;
  const V ab = hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b));
  const V ce = hn::Add(hn::InterleaveLower(d, c, e), hn::InterleaveUpper(d, c, e));
  const auto ab2 = hn::BitCast(pairs, ab), ce2 = hn::BitCast(pairs, ce);
  const V abce = hn::Add(hn::BitCast(d, hn::InterleaveLower(pairs, ab2, ce2)),
                         hn::BitCast(d, hn::InterleaveUpper(pairs, ab2, ce2)));
  HWY_ALIGN float blocks[HWY_MAX_BYTES / sizeof(float)];
  hn::Store(abce, d, blocks);
  auto sum = hn::LoadU(four, out);
  for (size_t i = 0; i < hn::Lanes(d); i += 4) sum = hn::Add(sum, hn::Load(four, blocks + i));
  hn::StoreU(sum, four, out);
#endif
}

/// kMr x 4 sums of the outer product.
template <int kMr>
HWY_INLINE void outer_block(const TileOuterProduct& t, int64_t row, int64_t column) {
  const D d;
  const int64_t lanes = int64_t(hn::Lanes(d));
  const float* HWY_RESTRICT g = t.g + row * t.g_pitch;
  const float* HWY_RESTRICT a = t.a + column * t.a_pitch;
  V sum[kMr][4];
#pragma GCC unroll 4
  for (int r = 0; r < kMr; ++r)
#pragma GCC unroll 4
    for (int c = 0; c < 4; ++c) sum[r][c] = hn::Zero(d);
  for (int64_t p = 0; p < t.pixels; p += lanes) {
    V left[kMr];
#pragma GCC unroll 4
    for (int r = 0; r < kMr; ++r) left[r] = hn::Load(d, g + r * t.g_pitch + p);
#pragma GCC unroll 4
    for (int c = 0; c < 4; ++c) {
      const V right = hn::Load(d, a + c * t.a_pitch + p);
#pragma GCC unroll 4
      for (int r = 0; r < kMr; ++r) sum[r][c] = hn::MulAdd(left[r], right, sum[r][c]);
    }
  }
#pragma GCC unroll 4
  for (int r = 0; r < kMr; ++r) {
    float* out = t.sums + (row + r) * t.stride + column;
    add_sums_of_four(d, sum[r][0], sum[r][1], sum[r][2], sum[r][3], out);
  }
}

HWY_INLINE float row_product(const float* HWY_RESTRICT g, const float* HWY_RESTRICT a, int64_t pixels) {
  const D d;
  V sum = hn::Zero(d);
  for (int64_t p = 0; p < pixels; p += int64_t(hn::Lanes(d)))
    sum = hn::MulAdd(hn::Load(d, g + p), hn::Load(d, a + p), sum);
  return hn::GetLane(hn::SumOfLanes(d, sum));
}

void outer_product_tile(const TileOuterProduct& t) {
  // Rows of g on the way through the second cache level, 8 rows of a in the first.
  constexpr int64_t kColumns = 8;
  constexpr int kRowBlock = kManyRegisters ? 4 : 2;
  for (int64_t first = 0; first < t.inputs; first += kColumns) {
    const int64_t last = std::min(first + kColumns, t.inputs);
    for (int64_t row = 0; row < t.outputs; row += kRowBlock) {
      int64_t column = first;
      if (row + kRowBlock <= t.outputs) {
        for (; column + 4 <= last; column += 4) outer_block<kRowBlock>(t, row, column);
      } else {
        for (; column + 4 <= last; column += 4)
          for (int64_t r = row; r < t.outputs; ++r) outer_block<1>(t, r, column);
      }
      for (; column < last; ++column)
        for (int64_t r = row; r < std::min(row + kRowBlock, t.outputs); ++r)
          t.sums[r * t.stride + column] +=
              row_product(t.g + r * t.g_pitch, t.a + column * t.a_pitch, t.pixels);
    }
  }
}

void row_sums_tile(const float* HWY_RESTRICT g, int64_t pitch, int64_t rows, int64_t pixels,
                   float* HWY_RESTRICT sums) {
  const D d;
  for (int64_t r = 0; r < rows; ++r) {
    V sum = hn::Zero(d);
    for (int64_t p = 0; p < pixels; p += int64_t(hn::Lanes(d)))
      sum = hn::Add(sum, hn::Load(d, g + r * pitch + p));
    sums[r] += hn::GetLane(hn::SumOfLanes(d, sum));
  }
}

void add_rows_tile(const float* HWY_RESTRICT g, int64_t rows, int64_t pitch, int64_t pixels,
                   float* HWY_RESTRICT total) {
  const D d;
  for (int64_t r = 0; r < rows; ++r)
    for (int64_t p = 0; p < pixels; p += int64_t(hn::Lanes(d))) {
      const int64_t i = r * pitch + p;
      hn::Store(hn::Add(hn::Load(d, total + i), hn::Load(d, g + i)), d, total + i);
    }
}

void leaky_relu_backward_tile(const float* HWY_RESTRICT a, float* HWY_RESTRICT g, int64_t rows, int64_t pitch,
                              int64_t pixels) {
  const D d;
  for (int64_t r = 0; r < rows; ++r)
    for (int64_t p = 0; p < pixels; p += int64_t(hn::Lanes(d))) {
      const int64_t i = r * pitch + p;
      const V gradient = hn::Load(d, g + i);
      const auto above = hn::Gt(hn::Load(d, a + i), hn::Zero(d));
      hn::Store(hn::IfThenElse(above, gradient, hn::Mul(gradient, hn::Set(d, float(kLeakySlope)))), d, g + i);
    }
}

void bounded_backward_tile(const float* HWY_RESTRICT a, float* HWY_RESTRICT g, int64_t rows, int64_t pitch,
                           int64_t pixels, float bound) {
  const D d;
  const V inverse = hn::Set(d, 1.0f / bound);
  for (int64_t r = 0; r < rows; ++r)
    for (int64_t p = 0; p < pixels; p += int64_t(hn::Lanes(d))) {
      const int64_t i = r * pitch + p;
      const V rest = hn::NegMulAdd(hn::Abs(hn::Load(d, a + i)), inverse, hn::Set(d, 1.0f));
      hn::Store(hn::Mul(hn::Load(d, g + i), hn::Mul(rest, rest)), d, g + i);
    }
}

void stream_rows_tile(const float* HWY_RESTRICT from, int64_t pitch, int64_t rows, int64_t pixels,
                      float* HWY_RESTRICT to, int64_t stride) {
  const D d;
  const int64_t lanes = int64_t(hn::Lanes(d));
  const bool aligned =
      reinterpret_cast<uintptr_t>(to) % (size_t(lanes) * sizeof(float)) == 0 && stride % lanes == 0;
  for (int64_t r = 0; r < rows; ++r) {
    int64_t p = 0;
    if (aligned)
      for (; p + lanes <= pixels; p += lanes)
        hn::Stream(hn::Load(d, from + r * pitch + p), d, to + r * stride + p);
    std::copy(from + r * pitch + p, from + r * pitch + pixels, to + r * stride + p);
  }
  hwy::FlushStream();
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

PackedWeights::PackedWeights(const float* weights, int64_t out_count, int64_t in_count, int64_t output_stride,
                             int64_t input_stride)
    : outputs(out_count), inputs(in_count) {
  const int64_t blocks = (outputs + kBlock - 1) / kBlock;
  data_ = hwy::AllocateAligned<float>(static_cast<size_t>(std::max<int64_t>(blocks * kBlock * inputs, 1)));
  float* out = data_.get();
  for (int64_t b = 0; b < blocks; ++b)
    for (int64_t i = 0; i < inputs; ++i)
      for (int64_t o = b * kBlock; o < (b + 1) * kBlock; ++o)
        *out++ = o < outputs ? weights[o * output_stride + i * input_stride] : 0.0f;
}

HWY_EXPORT(multiply_tile);
HWY_EXPORT(outer_product_tile);
HWY_EXPORT(row_sums_tile);
HWY_EXPORT(add_rows_tile);
HWY_EXPORT(leaky_relu_backward_tile);
HWY_EXPORT(bounded_backward_tile);
HWY_EXPORT(stream_rows_tile);

void multiply(const TileProduct& product) {
  HWY_DYNAMIC_DISPATCH(multiply_tile)(product);
}

void add_outer_product(const TileOuterProduct& product) {
  HWY_DYNAMIC_DISPATCH(outer_product_tile)(product);
}

void add_row_sums(const float* g, int64_t pitch, int64_t rows, int64_t pixels, float* sums) {
  HWY_DYNAMIC_DISPATCH(row_sums_tile)(g, pitch, rows, pixels, sums);
}

void add_rows(const float* g, int64_t rows, int64_t pitch, int64_t pixels, float* total) {
  HWY_DYNAMIC_DISPATCH(add_rows_tile)(g, rows, pitch, pixels, total);
}

void leaky_relu_backward(const float* a, float* g, int64_t rows, int64_t pitch, int64_t pixels) {
  HWY_DYNAMIC_DISPATCH(leaky_relu_backward_tile)(a, g, rows, pitch, pixels);
}

void bounded_backward(const float* a, float* g, int64_t rows, int64_t pitch, int64_t pixels, float bound) {
  HWY_DYNAMIC_DISPATCH(bounded_backward_tile)(a, g, rows, pitch, pixels, bound);
}

void stream_rows(const float* from, int64_t pitch, int64_t rows, int64_t pixels, float* to, int64_t stride) {
  HWY_DYNAMIC_DISPATCH(stream_rows_tile)(from, pitch, rows, pixels, to, stride);
}

}  // namespace ld
#endif
