// Rows of a 3x3 or 5x5 convolution, float32, for every SIMD width (Highway). A row of a picture is planar:
// its channels lie one behind the other, `pitch` floats apart, with kPixelStep zeros between them that stand
// for what is beyond the border. Free of LibTorch.
#pragma once

#include <array>
#include <vector>

#include "core/activation.h"
#include "ops/kernels/dense.h"

namespace ld {

/// The weights [outputs, inputs, kernel, kernel] of a convolution, the kernel 3 or 5, in the order in which
/// they are read: blocks of 8 outputs.
class PackedConvolution {
 public:
  PackedConvolution(const float* weights, const float* biases, int64_t outputs, int64_t inputs,
                    int64_t kernel = 3);
  static constexpr int64_t kBlock = 8;
  const float* block(int64_t output) const {
    return data_.get() + output / kBlock * kBlock * inputs * kernel * kernel;
  }
  const float* biases() const { return biases_.data(); }

  int64_t outputs, inputs, kernel;

 private:
  Floats data_;
  std::vector<float> biases_;
};

/// One of the pictures that are read, whose channels follow those of the one before: as many rows as the
/// kernel has, the middle one at the result.
struct ConvolutionSource {
  std::array<PlanarRow, 5> rows;
  int64_t channels = 0;
};

/// A row of the result from pixel `begin` on, a multiple of kPixelStep; what is behind pixel `width` is set
/// to 0.
struct ConvolutionRow {
  const PackedConvolution* weights = nullptr;
  std::vector<ConvolutionSource> sources;
  float* out = nullptr;
  int64_t out_pitch = 0;
  int64_t begin = 0, end = 0, width = 0;
  Activation activation = Activation::none;
  float slope = 0;  // below 0, of Activation::leaky_relu
};
void convolve(const ConvolutionRow& row);

}  // namespace ld
