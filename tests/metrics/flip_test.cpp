// FLIP and HDR-FLIP against the authors' program, and at the edges of their domain.
#include "metrics/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "metrics/metric.h"
#include "plain_metrics.h"

namespace ld {
namespace {

// tests/metrics/flip_reference.py printed them with flip-evaluator 1.7; it holds the formulas of the
// pictures.
struct Known {
  int width, height;
  double low, high, start, stop;
  int exposures;
};
constexpr Known kKnown[] = {
    {31, 33, 0.120547, 0.171216, -5.1687, 1.4508, 7}, {64, 48, 0.118138, 0.159110, -5.3360, 1.3809, 7},
    {1, 1, 0.586414, 0.636615, 3.4189, 3.4189, 2},    {2, 1, 0.394429, 0.619799, 2.6285, 2.6285, 2},
    {1, 40, 0.210633, 0.317593, -3.6462, 1.6467, 6},  {17, 12, 0.131494, 0.193726, -4.7658, 1.3809, 7},
};

TEST(Flip, AgreesWithTheAuthorsProgram) {
  for (const Known& known : kKnown) {
    SCOPED_TRACE(testing::Message() << known.width << "x" << known.height);
    Image r(known.width, known.height, 3), d = r;
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < r.height; ++y)
        for (int x = 0; x < r.width; ++x) {
          const int texture = (x * x * 37 + y * y * 101 + x * y * 3 + c * 59) % 256;
          const int tile = (x / 8 + y / 8) % 3 + 1;
          const int noise = (x * 7 + y * 13 + x * y * 5 + c * 3) % 17 - 8;
          const bool bright = (x * 3 + y * 5) % 41 == 7;
          r.at(c, x, y) = static_cast<float>(texture) / 128.0F * static_cast<float>(tile) / 2.0F *
                          (bright ? 32.0F : 1.0F);
          d.at(c, x, y) = std::max(r.at(c, x, y) + static_cast<float>(noise) / 32.0F, 0.0F);
        }
    EXPECT_NEAR(flip(d, r), known.low, 1e-4);
    EXPECT_NEAR(hdr_flip(d, r), known.high, 1e-4);
    const FlipExposures exposures = flip_exposures(r);
    EXPECT_NEAR(exposures.start, known.start, 1e-3);
    EXPECT_NEAR(exposures.stop, known.stop, 1e-3);
    EXPECT_EQ(exposures.count, known.exposures);
  }
}

TEST(Flip, EqualPicturesHaveNoneAndBlackAgainstWhiteAlmostTheMost) {
  const Image image = plain::random_image(19, 14, 1);
  EXPECT_EQ(flip(image, image), 0);
  EXPECT_EQ(hdr_flip(image, image), 0);
  Image black(32, 32, 3), white(32, 32, 3);
  for (float& x : white.pixels) x = 10;
  EXPECT_GT(flip(black, white), 0.9);
  EXPECT_LE(flip(black, white), 1);
}

TEST(Flip, GreenAgainstBlueIsTheLargestDifferenceOfColours) {
  std::vector<double> green(3 * 64, 0), blue(3 * 64, 0);
  std::fill(green.begin() + 64, green.begin() + 128, 1.0);
  std::fill(blue.begin() + 128, blue.end(), 1.0);
  for (const double error : flip_map(green, blue, 8, 8)) EXPECT_NEAR(error, 1, 1e-12);
}

TEST(Flip, NoiseCountsLessWhenTheEyeBlursIt) {
  std::vector<double> grey(3 * 48 * 48, 0.5), checked = grey, halved = grey;
  for (size_t i = 0; i < grey.size(); ++i) {
    checked[i] += (i % 48 + i / 48) % 2 == 0 ? 0.2 : -0.2;
    halved[i] += i % 48 < 24 ? 0.2 : -0.2;
  }
  const auto mean = [](const std::vector<double>& map) {
    double sum = 0;
    for (const double x : map) sum += x;
    return sum / static_cast<double>(map.size());
  };
  EXPECT_LT(mean(flip_map(checked, grey, 48, 48)), 0.5 * mean(flip_map(halved, grey, 48, 48)));
}

TEST(Flip, ExtremesGiveNumbersFromZeroToOne) {
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 1}, {7, 5}})
    for (const float extreme :
         {0.0F, std::numeric_limits<float>::denorm_min(), 1e-38F, 65504.0F, 3e38F, -1.0F, -3e38F})
      for (const float other : {0.0F, std::numeric_limits<float>::denorm_min(), 1.0F, 65504.0F, 3e38F}) {
        SCOPED_TRACE(testing::Message() << width << "x" << height << ": " << extreme << " against " << other);
        Image d(width, height, 3), r(width, height, 3);
        d.pixels[0] = extreme;
        r.pixels.back() = other;
        for (const Metric& metric : further_metrics()) {
          const double score = metric.compute(d, r);
          EXPECT_TRUE(score >= 0 && score <= 1) << metric.name << " " << score;
          EXPECT_EQ(metric.compute(r, r), 0) << metric.name;
        }
      }
}

TEST(Flip, ABrokenPictureHasNoScoreAndABrokenReferenceIsAnError) {
  const Image reference = plain::random_image(6, 5, 2);
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Image denoised = reference;
    denoised.pixels[17] = bad;
    for (const Metric& metric : further_metrics()) {
      EXPECT_TRUE(std::isnan(metric.compute(denoised, reference))) << metric.name;
      EXPECT_THROW(metric.compute(reference, denoised), Error) << metric.name;
    }
  }
}

TEST(Flip, IsChosenByName) {
  EXPECT_EQ(metrics_with({}).size(), 4U);
  const auto chosen = metrics_with({"hdr_flip", "flip", "hdr_flip"});
  ASSERT_EQ(chosen.size(), 6U);
  EXPECT_EQ(chosen[4]->name, "hdr_flip");
  try {
    metrics_with({"hdrflip"});
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'hdr_flip'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace ld
