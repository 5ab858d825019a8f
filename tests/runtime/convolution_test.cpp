#include "ops/kernels/convolution.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "ops/kernels/instruction_sets.h"
#include "runtime/row_window.h"

namespace ld {
namespace {

std::vector<float> random_floats(int64_t count, uint32_t seed) {
  RandomStream random(seed, RandomPurpose::test);
  std::vector<float> values(static_cast<size_t>(count));
  for (float& value : values) value = random.uniform(-1.0F, 1.0F);
  return values;
}

/// A window with memory of its own, zeros but for its pixels.
struct Picture {
  RowWindow window;
  Floats memory;
  Picture(int64_t channels, int64_t width, int64_t height, uint32_t seed)
      : window(channels, width, height, height) {
    memory = hwy::AllocateAligned<float>(size_t(window.floats()));
    std::fill_n(memory.get(), window.floats(), 0.0F);
    window.memory = memory.get();
    const std::vector<float> values = random_floats(channels * width * height, seed);
    for (int64_t y = 0; y < height; ++y)
      for (int64_t c = 0; c < channels; ++c)
        std::copy_n(values.data() + (y * channels + c) * width, width, window.row(y, c));
  }
};

/// One output of the convolution over the channels of both pictures, in double.
double plain(const std::vector<const Picture*>& pictures, const std::vector<float>& weights, int64_t inputs,
             int64_t o, int64_t y, int64_t x, float bias) {
  double sum = bias;
  int64_t i = 0;
  for (const Picture* picture : pictures)
    for (int64_t c = 0; c < picture->window.planes; ++c, ++i)
      for (int64_t ky = 0; ky < 3; ++ky)
        for (int64_t kx = 0; kx < 3; ++kx) {
          const int64_t v = y + ky - 1, u = x + kx - 1;
          if (v < 0 || u < 0 || v >= picture->window.height || u >= picture->window.width) continue;
          sum += double(weights[size_t(((o * inputs + i) * 3 + ky) * 3 + kx)]) *
                 double(picture->window.row(v, c)[u]);
        }
  return sum;
}

TEST(Convolution, IsThePlainSumAtEverySizeOnEveryInstructionSet) {
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    for (const int64_t width : {1, 2, 15, 16, 17, 50, 97})
      for (const int64_t outputs : {1, 3, 8, 13}) {
        const int64_t height = 3;
        const Picture first(2, width, height, 1), second(3, width, height, 2);
        Picture result(outputs, width, height, 3);
        const std::vector<float> weights = random_floats(outputs * 5 * 9, 4),
                                 biases = random_floats(outputs, 5);
        const PackedConvolution packed(weights.data(), biases.data(), outputs, 5);
        const std::vector<float> zeros(size_t(padded(width) + 2 * kPixelStep), 0.0F);
        for (int64_t y = 0; y < height; ++y) {
          const auto row_of = [&](const Picture& p, int64_t v) {
            return v < 0 || v >= height ? PlanarRow{zeros.data() + kPixelStep, 0} : p.window.planar(v);
          };
          ConvolutionRow row;
          row.weights = &packed;
          for (const Picture* p : {&first, &second})
            row.sources.push_back({{row_of(*p, y - 1), row_of(*p, y), row_of(*p, y + 1)}, p->window.planes});
          row.out = result.window.row(y);
          row.out_pitch = result.window.pitch;
          row.end = padded(width);
          row.width = width;
          row.activated = true;
          convolve(row);
          for (int64_t o = 0; o < outputs; ++o) {
            for (int64_t x = 0; x < width; ++x) {
              const double sum = plain({&first, &second}, weights, 5, o, y, x, biases[size_t(o)]);
              EXPECT_NEAR(result.window.row(y, o)[x], sum > 0 ? sum : kLeakySlope * sum, 2e-6)
                  << set << ", width " << width << ", output " << o << ", pixel " << x << ", " << y;
            }
            for (int64_t x = width; x < padded(width); ++x) EXPECT_EQ(result.window.row(y, o)[x], 0.0F);
          }
        }
      }
  }
  use_instruction_set("");
}

}  // namespace
}  // namespace ld
