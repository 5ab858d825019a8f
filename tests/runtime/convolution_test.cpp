#include "ops/kernels/convolution.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "ops/kernels/instruction_sets.h"
#include "ops/kernels/quantised_convolution.h"
#include "ops/kernels/winograd.h"
#include "runtime/row_window.h"
#include "tests/support/expect_error.h"

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

/// Both pictures, the weights of a convolution over their channels, and what it must come to.
struct Case {
  Picture first, second;
  std::vector<float> weights, biases;
  std::vector<float> zeros;

  Case(int64_t width, int64_t height, int64_t outputs)
      : first(2, width, height, 1),
        second(3, width, height, 2),
        weights(random_floats(outputs * 5 * 9, 4)),
        biases(random_floats(outputs, 5)),
        zeros(size_t(padded(width) + 5 * kPixelStep), 0.0F) {}

  /// The sources of rows [y, y + N).
  template <class Source>
  std::vector<Source> sources(int64_t y) const {
    std::vector<Source> made;
    for (const Picture* p : {&first, &second}) {
      Source source;
      source.channels = p->window.planes;
      for (size_t i = 0; i < source.rows.size(); ++i) {
        const int64_t v = y + int64_t(i);
        source.rows[i] =
            v < 0 || v >= p->window.height ? PlanarRow{zeros.data() + kPixelStep, 0} : p->window.planar(v);
      }
      made.push_back(source);
    }
    return made;
  }

  /// Leaky, with zeros behind the last pixel.
  void expect(const Picture& result, double tolerance, const std::string& where) const {
    const RowWindow& window = result.window;
    for (int64_t y = 0; y < window.height; ++y)
      for (int64_t o = 0; o < window.planes; ++o) {
        for (int64_t x = 0; x < window.width; ++x) {
          const double sum = plain({&first, &second}, weights, 5, o, y, x, biases[size_t(o)]);
          ASSERT_NEAR(window.row(y, o)[x], sum > 0 ? sum : kLeakySlope * sum, tolerance)
              << where << ", width " << window.width << ", output " << o << ", pixel " << x << ", " << y;
        }
        for (int64_t x = window.width; x < padded(window.width); ++x) EXPECT_EQ(window.row(y, o)[x], 0.0F);
      }
  }
};

TEST(Convolution, IsThePlainSumAtEverySizeOnEveryInstructionSet) {
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    for (const int64_t width : {1, 2, 15, 16, 17, 50, 97})
      for (const int64_t outputs : {1, 3, 8, 13}) {
        const Case given(width, 3, outputs);
        const PackedConvolution packed(given.weights.data(), given.biases.data(), outputs, 5);
        Picture result(outputs, width, 3, 3);
        for (int64_t y = 0; y < 3; ++y)
          convolve({&packed, given.sources<ConvolutionSource>(y - 1), result.window.row(y),
                    result.window.pitch, 0, padded(width), width, Activation::leaky_relu,
                    float(kLeakySlope)});
        given.expect(result, 2e-6, set);
      }
  }
  use_instruction_set("");
}

/// All rows by tiles of 2x2 results.
template <class Weights, class Scratch>
Picture by_tiles(const Case& given, const Weights& weights, bool activated) {
  const int64_t width = given.first.window.width, height = given.first.window.height;
  Scratch scratch(weights);
  Picture result(weights.outputs, width, height, 3);
  for (int64_t y = 0; y < height; y += 2)
    for (int64_t x = 0; x < padded(width); x += kWinogradPixels)
      convolve(TileRows<Weights>{&weights,
                                 given.sources<WinogradSource>(y - 1),
                                 {result.window.row(y), y + 1 < height ? result.window.row(y + 1) : nullptr},
                                 result.window.pitch,
                                 x,
                                 std::min(x + kWinogradPixels, padded(width)),
                                 width,
                                 activated ? float(kLeakySlope) : 1.0F},
               scratch);
  return result;
}

TEST(Convolution, ByTilesIsThePlainSumToo) {
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    for (const int64_t width : {1, 2, 15, 16, 31, 50, 96, 97, 200})
      for (const int64_t outputs : {1, 3, 13})
        for (const int64_t height : {1, 2, 5}) {
          const Case given(width, height, outputs);
          const WinogradWeights weights(given.weights.data(), given.biases.data(), outputs, 5);
          given.expect(by_tiles<WinogradWeights, WinogradScratch>(given, weights, true), 4e-6, set);
        }
  }
  use_instruction_set("");
}

/// Weights of 8 bits, as far as they go, and pictures whose values are whole levels.
struct LevelsCase : Case {
  std::vector<int8_t> levels;
  std::vector<float> ones, none;

  /// Every weight is `weight` and every value `value` levels; random ones where that is null.
  LevelsCase(int64_t width, int64_t height, int64_t outputs, const int* weight = nullptr,
             const float* value = nullptr)
      : Case(width, height, outputs), ones(size_t(outputs), 1.0F), none(size_t(outputs), 0.0F) {
    for (float& w : weights) {
      levels.push_back(int8_t(weight != nullptr ? *weight : int(std::lround(w * 127))));
      w = levels.back();
    }
    biases = none;
    for (Picture* picture : {&first, &second})
      for (int64_t y = 0; y < height; ++y)
        for (int64_t c = 0; c < picture->window.planes; ++c)
          for (int64_t x = 0; x < width; ++x) {
            float& pixel = picture->window.row(y, c)[x];
            pixel = value != nullptr ? *value : std::round(pixel * float(most()));
          }
  }
  QuantisedWeights quantised() const {
    return {levels.data(), ones.data(), none.data(), int64_t(ones.size()), 5};
  }
  int most() const { return activation_levels(quantised()); }
  /// A level is 1.
  Picture result() const {
    return by_tiles<PackedQuantisedWeights, QuantisedScratch>(
        *this, PackedQuantisedWeights(quantised(), float(most())), false);
  }
  void expect_plain(const std::string& where) const {
    const Picture made = result();
    const RowWindow& window = made.window;
    for (int64_t y = 0; y < window.height; ++y)
      for (int64_t o = 0; o < window.planes; ++o) {
        for (int64_t x = 0; x < window.width; ++x)
          ASSERT_EQ(window.row(y, o)[x], float(plain({&first, &second}, weights, 5, o, y, x, 0)))
              << where << ", width " << window.width << ", output " << o << ", pixel " << x << ", " << y;
        for (int64_t x = window.width; x < padded(window.width); ++x) EXPECT_EQ(window.row(y, o)[x], 0.0F);
      }
  }
};

TEST(QuantisedConvolution, IsThePlainSumOfWholeNumbersOnEveryInstructionSet) {
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    for (const int64_t width : {1, 2, 15, 16, 31, 50, 96, 97, 200})
      for (const int64_t outputs : {1, 3, 13})
        for (const int64_t height : {1, 2, 5}) LevelsCase(width, height, outputs).expect_plain(set);
  }
  use_instruction_set("");
}

TEST(QuantisedConvolution, TheLargestWeightsAndActivationsDoNotWrap) {
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    for (const int weight : {-128, 127, 0})
      for (const float sign : {-1.0F, 1.0F, 0.0F}) {
        const float value = sign * kMostLevel;
        LevelsCase(33, 4, 3, &weight, &value).expect_plain(set);
      }
  }
  use_instruction_set("");
  std::vector<int8_t> many(size_t(1024 * 9), -128);
  const float one = 1, none = 0;
  const QuantisedWeights wide = {many.data(), &one, &none, 1, 1024};
  EXPECT_EQ(activation_levels(wide), ((int64_t{1} << 31) - 1) / (4 * 1024 * 9 * 128));
  many.resize(size_t{1} << 23, 127);
  EXPECT_ERROR(activation_levels({many.data(), &one, &none, 1, int64_t(many.size()) / 9}), "leave 32 bits");
}

TEST(QuantisedConvolution, WhatIsBeyondTheRangeCountsAsTheRange) {
  const int weight = 1;
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    for (const float beyond : {1e5F, 3e38F, HUGE_VALF, -3e38F, -HUGE_VALF}) {
      const float range = std::copysign(float(kMostLevel), beyond);
      const Picture cut = LevelsCase(20, 3, 2, &weight, &beyond).result(),
                    largest = LevelsCase(20, 3, 2, &weight, &range).result();
      EXPECT_TRUE(std::equal(cut.memory.get(), cut.memory.get() + cut.window.floats(), largest.memory.get()))
          << set << ", " << beyond;
    }
    const float nan = std::nanf(""), small = 1e-40F;
    for (const float* value : {&nan, &small}) {
      const Picture made = LevelsCase(20, 3, 2, &weight, value).result();
      for (int64_t x = 0; x < 20; ++x)
        EXPECT_LE(std::abs(made.window.row(1)[x]), 45.0F * kMostLevel) << set << ", " << *value;
    }
  }
  use_instruction_set("");
}

}  // namespace
}  // namespace ld
