// A 3x3 convolution by tiles of 2x2 results (Winograd; Lavin and Gray 2016, "Fast Algorithms for
// Convolutional Neural Networks", section 4.1): 16 products for 4 results instead of 36. Pictures lie as for
// ops/kernels/convolution.h. Free of LibTorch.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "ops/kernels/dense.h"

namespace ld {

/// The weights [outputs, inputs, 3, 3] of a convolution as G g G^T: 16 matrices [outputs, inputs].
class WinogradWeights {
 public:
  WinogradWeights(const float* weights, const float* biases, int64_t outputs, int64_t inputs);

  static constexpr int64_t kBytesOfOne = sizeof(float);  // of the weights that came
  /// Of the matrices.
  int64_t bytes() const { return 16 * outputs * inputs * kBytesOfOne; }

  int64_t outputs, inputs;
  std::vector<PackedWeights> matrices;
  std::vector<float> biases;
};

/// Of a stretch: tiles enough for whole blocks of the products, few enough for the second cache level.
constexpr int64_t kWinogradPixels = 96;

/// One thread's memory for a stretch.
struct WinogradScratch {
  Floats inputs, products;  // [16][inputs or outputs][tiles]
  explicit WinogradScratch(const WinogradWeights& weights);
  static int64_t bytes(const WinogradWeights& weights) {
    return 8 * kWinogradPixels * (weights.inputs + weights.outputs) * int64_t(sizeof(float));
  }
};

/// One of the pictures that are read, whose channels follow those of the one before: the row above the
/// results, their two rows, and the row below.
struct WinogradSource {
  std::array<PlanarRow, 4> rows;
  int64_t channels = 0;
};

/// Two rows of the result, either of which may be null, from pixel `begin` on, a multiple of kPixelStep, at
/// most kWinogradPixels; what is behind pixel `width` is set to 0. Of each source 2 kPixelStep + 2 floats
/// behind pixel `end` can be read.
template <class Weights>
struct TileRows {
  const Weights* weights = nullptr;
  std::vector<WinogradSource> sources;
  std::array<float*, 2> out = {};
  int64_t out_pitch = 0;
  int64_t begin = 0, end = 0, width = 0;
  float slope = 1;  // below 0, of the leaky ReLU behind it; 1: none

  /// Zeros again where the next convolution takes what it reads for the border.
  void clear_tail() const {
    const int64_t first = std::min(std::max(begin, width), end);
    for (float* row : out)
      for (int64_t o = 0; row != nullptr && o < weights->outputs; ++o)
        std::fill(row + o * out_pitch + first, row + o * out_pitch + end, 0.0f);
  }
};
using WinogradRows = TileRows<WinogradWeights>;
void convolve(const WinogradRows& rows, WinogradScratch& scratch);

}  // namespace ld
