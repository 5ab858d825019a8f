// What must hold for any pair of pictures; every test walks the registry, so a new metric is tested the day
// it is written.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "metrics/metric.h"
#include "metrics/smape.h"
#include "metrics/ssim.h"
#include "plain_metrics.h"

namespace ld {
namespace {

Image mirrored(const Image& image, bool in_x, bool in_y) {
  Image result(image.width, image.height, image.channels);
  for (int c = 0; c < image.channels; ++c)
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        result.at(c, in_x ? image.width - 1 - x : x, in_y ? image.height - 1 - y : y) = image.at(c, x, y);
  return result;
}

Image transposed(const Image& image) {
  Image result(image.height, image.width, image.channels);
  for (int c = 0; c < image.channels; ++c)
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) result.at(c, y, x) = image.at(c, x, y);
  return result;
}

Image channels_rotated(const Image& image) {
  Image result = image;
  std::rotate(result.pixels.begin(), result.pixels.begin() + static_cast<std::ptrdiff_t>(image.plane_size()),
              result.pixels.end());
  return result;
}

TEST(MetricsProperty, EqualPicturesGetTheBestScore) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 2}, {31, 33}}) {
    const Image image = plain::random_image(width, height, 10);
    for (const Metric& metric : metrics()) {
      const double score = metric.compute(image, image);
      if (metric.best == Best::lowest) {
        EXPECT_EQ(score, 0) << metric.name;
      } else {
        EXPECT_EQ(score, metric.name == "ssim" ? 1 : std::numeric_limits<double>::infinity()) << metric.name;
      }
    }
  }
}

TEST(MetricsProperty, MoreNoiseIsWorse) {
  const Image reference = plain::random_image(48, 40, 11);
  for (const Metric& metric : metrics()) {
    double before = metric.compute(reference, reference);
    for (const double amount : {0.05, 0.2, 0.8}) {
      const double score = metric.compute(plain::with_noise(reference, amount, 12), reference);
      EXPECT_TRUE(better(metric, before, score))
          << metric.name << " at " << amount << ": " << before << ", " << score;
      before = score;
    }
  }
}

TEST(MetricsProperty, FlipsTranspositionAndTheOrderOfChannelsChangeNothing) {
  for (const auto& [width, height] : {std::pair{1, 2}, {6, 5}, {31, 33}}) {
    const Image r = plain::random_image(width, height, 13), d = plain::with_noise(r, 0.4, 14);
    for (const Metric& metric : metrics()) {
      const double score = metric.compute(d, r);
      const double tolerance = 1e-12 * std::max(1.0, std::abs(score));
      EXPECT_NEAR(metric.compute(mirrored(d, true, false), mirrored(r, true, false)), score, tolerance)
          << metric.name;
      EXPECT_NEAR(metric.compute(mirrored(d, false, true), mirrored(r, false, true)), score, tolerance)
          << metric.name;
      EXPECT_NEAR(metric.compute(transposed(d), transposed(r)), score, tolerance) << metric.name;
      EXPECT_NEAR(metric.compute(channels_rotated(d), channels_rotated(r)), score, tolerance) << metric.name;
    }
  }
}

TEST(MetricsProperty, SmapeAndSsimAreSymmetric) {
  const Image r = plain::random_image(20, 15, 15), d = plain::with_noise(r, 0.7, 16);
  EXPECT_EQ(smape(d, r), smape(r, d));
  EXPECT_NEAR(ssim(d, r), ssim(r, d), 1e-14);
}

TEST(MetricsProperty, SsimSeesThePixelsAtTheBorder) {
  // Border centres are cropped, border pixels are not: the windows of the first centres hold them.
  const Image r = plain::random_image(16, 16, 17);
  Image d = r;
  d.at(0, 0, 0) = r.at(0, 0, 0) + 1;
  EXPECT_LT(ssim(d, r), 1);
}

TEST(MetricsProperty, BetterFollowsTheDirectionAndNeverPrefersNan) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(better(find_metric("relmse"), 0.1, 0.2));
  EXPECT_FALSE(better(find_metric("relmse"), 0.2, 0.2));
  EXPECT_TRUE(better(find_metric("psnr"), 30, 20));
  for (const Metric& metric : metrics()) {
    EXPECT_FALSE(better(metric, nan, 1));
    EXPECT_TRUE(better(metric, 1, nan));
    EXPECT_FALSE(better(metric, nan, nan));
  }
}

}  // namespace
}  // namespace ld
