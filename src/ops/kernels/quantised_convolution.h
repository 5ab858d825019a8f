// A 3x3 convolution of activations with weights of 8 bits, in whole numbers, for every SIMD width (Highway).
// It runs by tiles of 2x2 results as ops/kernels/winograd.h does: 4 G g G^T and B^T d B of whole numbers are
// whole numbers of 16 bits, whose products two at a time are added to 32. So sums are exactly those of the
// convolution, times 4, in any order and on every processor. Pictures lie as for ops/kernels/convolution.h.
// Free of LibTorch.
#pragma once

#include <cstdint>
#include <vector>

#include "ops/kernels/winograd.h"

namespace ld {

/// Activations count in levels from -n to n, n at most this: four of them fit 16 bits.
constexpr int kMostLevel = 8191;

/// The weights [outputs, inputs, 3, 3] of a convolution, quantised for each output: w is about q * scale.
struct QuantisedWeights {
  const int8_t* values = nullptr;
  const float* scales = nullptr;  // [outputs]
  const float* biases = nullptr;  // [outputs]
  int64_t outputs = 0, inputs = 0;
};

/// n for such weights: as many as surely keep sums within 32 bits. Throws Error where that is less than 1.
int activation_levels(const QuantisedWeights& weights);

/// 4 G g G^T, 16 matrices [outputs, inputs], in the order in which they are read: blocks of 8 outputs, two
/// inputs of each side by side.
class PackedQuantisedWeights {
 public:
  /// Activations beyond +-range count as +-range. Throws Error as activation_levels() does.
  PackedQuantisedWeights(const QuantisedWeights& weights, float range);
  static constexpr int64_t kBytesOfOne = sizeof(int8_t);  // of the weights that came
  static constexpr int64_t kBlock = 8;
  /// Of the matrices.
  int64_t bytes() const { return 16 * blocks_ * kBlock * pairs * int64_t(sizeof(int32_t)); }
  const int32_t* block(int64_t matrix, int64_t output) const {
    return pairs_.get() + (matrix * blocks_ * kBlock + output / kBlock * kBlock) * pairs;
  }

  int64_t outputs, inputs, pairs;  // of inputs
  float levels, levels_per_unit;   // of activations
  std::vector<float> scales;       // of the sums, for each output
  std::vector<float> biases;

 private:
  int64_t blocks_;
  hwy::AlignedFreeUniquePtr<int32_t[]> pairs_;  // each two numbers of 16 bits
};

/// One thread's memory for a stretch.
struct QuantisedScratch {
  hwy::AlignedFreeUniquePtr<int32_t[]> memory;
  explicit QuantisedScratch(const PackedQuantisedWeights& weights);
  static int64_t bytes(const PackedQuantisedWeights& weights);
};

using QuantisedRows = TileRows<PackedQuantisedWeights>;
void convolve(const QuantisedRows& rows, QuantisedScratch& scratch);

}  // namespace ld
