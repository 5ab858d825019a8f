#include "render/geometry/sample_numbers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace ld {
namespace {

TEST(SampleNumbers, EveryRunOfAPowerOfTwoIsANet) {
  // A (0, 2)-sequence: of points 2^k i ... 2^k (i + 1) - 1 every box of area 2^-k with sides of powers of two
  // holds one.
  constexpr int kLog = 6, kCount = 1 << kLog;
  for (const uint32_t seed : {1U, 2U, 12345U})
    for (const uint32_t run : {0U, 3U})
      for (const uint32_t pair : {0U, 5U})
        for (int log_x = 0; log_x <= kLog; ++log_x) {
          std::set<int> boxes;
          for (uint32_t i = 0; i < kCount; ++i) {
            SampleNumbers numbers(seed, run * kCount + i);
            numbers.seek(pair);
            const Vec2 p = numbers.two();
            ASSERT_TRUE(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1);
            const int columns = 1 << log_x, rows = kCount / columns;
            boxes.insert(static_cast<int>(p.x * static_cast<float>(columns)) * rows +
                         static_cast<int>(p.y * static_cast<float>(rows)));
          }
          EXPECT_EQ(boxes.size(), static_cast<size_t>(kCount)) << "2^" << log_x << " columns";
        }
}

TEST(SampleNumbers, PointsOfOneIndexAreUniformOverSeeds) {
  // What makes the mean unbiased: over the scramblings a point, and a pair of different places, is uniform.
  constexpr int kSeeds = 32000, kBins = 8;
  std::vector<int> plane(kBins * kBins, 0), across(kBins * kBins, 0);
  for (uint32_t seed = 0; seed < kSeeds; ++seed) {
    RandomStream random(1, RandomPurpose::reference, 0, seed);
    SampleNumbers numbers(random.bits(), 5);
    const Vec2 p = numbers.two();
    const float other = numbers.one();
    const auto bin = [](float v) { return static_cast<size_t>(v * kBins); };
    ++plane[bin(p.x) * kBins + bin(p.y)];
    ++across[bin(p.x) * kBins + bin(other)];
  }
  for (const std::vector<int>& counts : {plane, across}) {
    double chi2 = 0;
    const double expected = double{kSeeds} / (kBins * kBins);
    for (const int count : counts) chi2 += (count - expected) * (count - expected) / expected;
    EXPECT_LT(chi2, 63 + 5 * std::sqrt(2.0 * 63));  // 63 degrees of freedom
  }
}

TEST(SampleNumbers, SpreadSamplesIntegrateBetter) {
  // A product over two places of the sequence, as light and BSDF are; its integral is 1/4.
  double spread = 0, independent = 0;
  constexpr int kTrials = 300, kSamples = 64;
  for (uint32_t trial = 0; trial < kTrials; ++trial) {
    double sums[2] = {0, 0};
    for (uint32_t i = 0; i < kSamples; ++i) {
      SampleNumbers numbers[2] = {{trial * 7919 + 13, i},
                                  SampleNumbers(RandomStream(1, RandomPurpose::test, trial, i))};
      for (int k = 0; k < 2; ++k) {
        const Vec2 a = numbers[k].two();
        const float b = numbers[k].one();
        sums[k] += a.x * a.y * (0.5F + b);
      }
    }
    spread += std::pow(sums[0] / kSamples - 0.25, 2);
    independent += std::pow(sums[1] / kSamples - 0.25, 2);
  }
  EXPECT_LT(spread, independent / 4);
}

TEST(SampleNumbers, IndependentNumbersAreTheStream) {
  RandomStream stream(3, RandomPurpose::input_samples, 1, 2, 3);
  SampleNumbers numbers{stream};
  EXPECT_EQ(numbers.one(), stream.uniform());
  numbers.seek(9);
  const Vec2 p = numbers.two();
  EXPECT_EQ(p.x, stream.uniform());
  EXPECT_EQ(p.y, stream.uniform());
}

}  // namespace
}  // namespace ld
