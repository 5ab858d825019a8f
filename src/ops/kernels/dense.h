// Products of small weight matrices with tiles of pixels, float32, for every SIMD width (Highway, chosen at
// run time): the arithmetic of ops/fully_connected.h. A tile is planar, [channels][pitch] with 64-byte
// aligned rows of a multiple of kPixelStep pixels.
#pragma once

#include <hwy/aligned_allocator.h>

#include <cstdint>

#include "ops/kernels/constants.h"

namespace ld {

constexpr int64_t kPixelStep = 16;  // floats of the widest vector that is dispatched to

inline int64_t padded(int64_t pixels) {
  return (pixels + kPixelStep - 1) / kPixelStep * kPixelStep;
}

/// A row of planes: channel c of pixel x is data[c * pitch + x]. A pitch of 0 gives every channel the same
/// row.
struct PlanarRow {
  const float* data = nullptr;
  int64_t pitch = 0;
  const float* plane(int64_t c) const { return data + c * pitch; }
};

/// The same, to be written.
struct PlanarTarget {
  float* data = nullptr;
  int64_t pitch = 0;
  float* plane(int64_t c) const { return data + c * pitch; }
  operator PlanarRow() const { return {data, pitch}; }
};

using Floats = hwy::AlignedFreeUniquePtr<float[]>;

/// A matrix in the order in which multiply() reads it: blocks of 8 outputs, each input by input.
class PackedWeights {
 public:
  /// Element (o, i) is weights[o * output_stride + i * input_stride].
  PackedWeights(const float* weights, int64_t outputs, int64_t inputs, int64_t output_stride,
                int64_t input_stride);

  static constexpr int64_t kBlock = 8;
  const float* block(int64_t output) const { return data_.get() + output / kBlock * kBlock * inputs; }

  int64_t outputs, inputs;

 private:
  Floats data_;
};

/// What becomes of a sum before it is stored: nothing, leaky ReLU, the bound of
/// ops/fully_connected.h, or, in a backward pass, the product with leaky ReLU's derivative where it put out
/// `activated`.
enum class Epilogue { none, leaky_relu, bounded, leaky_relu_backward };

/// out = epilogue(weights * in + bias + offset).
struct TileProduct {
  const PackedWeights* weights = nullptr;
  const float* in = nullptr;  // [inputs][in_pitch]
  int64_t in_pitch = 0;
  const float* bias = nullptr;    // [outputs], may be null
  const float* offset = nullptr;  // [outputs][offset_pitch], may be null
  int64_t offset_pitch = 0;
  float* out = nullptr;  // [outputs][out_pitch]
  int64_t out_pitch = 0;
  const float* activated = nullptr;  // [outputs][activated_pitch], for leaky_relu_backward
  int64_t activated_pitch = 0;
  int64_t pixels = 0;  // a multiple of kPixelStep
  float bound = 0;     // for Epilogue::bounded
  Epilogue epilogue = Epilogue::none;
};
void multiply(const TileProduct& product);

/// sums[o * stride + i] += sum over pixels of g[o][.] * a[i][.]: the gradient of a weight matrix.
struct TileOuterProduct {
  const float* g;  // [outputs][g_pitch]
  int64_t g_pitch, outputs;
  const float* a;  // [inputs][a_pitch]
  int64_t a_pitch, inputs;
  int64_t pixels;  // a multiple of kPixelStep
  float* sums;
  int64_t stride;
};
void add_outer_product(const TileOuterProduct& product);

/// sums[r] += sum over pixels of g[r][.].
void add_row_sums(const float* g, int64_t pitch, int64_t rows, int64_t pixels, float* sums);

/// g *= 1 where a > 0 and kLeakySlope elsewhere, over a tile of `rows` rows: back through a leaky ReLU whose
/// result was a.
void leaky_relu_backward(const float* a, float* g, int64_t rows, int64_t pitch, int64_t pixels);

/// g *= (1 - |a| / bound)^2 over a tile: back through the bound of ops/fully_connected.h whose result was a.
void bounded_backward(const float* a, float* g, int64_t rows, int64_t pitch, int64_t pixels, float bound);

/// total += g over all rows of a tile.
void add_rows(const float* g, int64_t rows, int64_t pitch, int64_t pixels, float* total);

/// Copies `pixels` floats of each row to memory that will not be read soon: past the caches where it is
/// aligned to whole vectors.
void stream_rows(const float* from, int64_t pitch, int64_t rows, int64_t pixels, float* to, int64_t stride);

}  // namespace ld
