#include "evaluation/gaussian_blur.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "test_frames.h"

namespace ld {
namespace {

/// The definition as four nested loops: a square window of 3 sigma, weights normalised over the part inside.
double plain_blur(const Image& image, double sigma, int c, int cx, int cy) {
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  double sum = 0, weight_sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (std::abs(x - cx) > radius || std::abs(y - cy) > radius) continue;
      const double weight = std::exp(-((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (2 * sigma * sigma));
      sum += weight * image.at(c, x, y);
      weight_sum += weight;
    }
  return sum / weight_sum;
}

TEST(GaussianBlur, AgreesWithPlainLoopsAtAwkwardSizesAndWidths) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 2}, {7, 3}, {31, 33}})
    for (const double sigma : {0.5, 1.3, 8.0}) {
      const Image image = mean_radiance(noisy_frame("", width, height, 1, 3).frame);
      const Image blurred = gaussian_blur(image, sigma);
      ASSERT_EQ(blurred.width, width);
      ASSERT_EQ(blurred.height, height);
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < height; ++y)
          for (int x = 0; x < width; ++x)
            ASSERT_NEAR(blurred.at(c, x, y) / plain_blur(image, sigma, c, x, y), 1, 1e-7)
                << sigma << ": " << x << " " << y;
    }
}

TEST(GaussianBlur, AConstantStaysItselfUpToTheBordersAndAtEveryMagnitude) {
  for (const float value : {0.0F, 1e-38F, 0.7F, 65504.0F, 3e38F}) {
    Image image(20, 9, 3);
    for (float& x : image.pixels) x = value;
    for (const float x : gaussian_blur(image, 4).pixels) ASSERT_FLOAT_EQ(x, value);
  }
}

TEST(GaussianBlur, DoesNotMixChannels) {
  Image image(9, 9, 3);
  image.at(1, 4, 4) = 1;
  const Image blurred = gaussian_blur(image, 1);
  for (size_t i = 0; i < blurred.plane_size(); ++i) {
    ASSERT_EQ(blurred.plane(0)[i], 0);
    ASSERT_EQ(blurred.plane(2)[i], 0);
  }
  EXPECT_GT(blurred.at(1, 5, 4), 0);
  EXPECT_FLOAT_EQ(blurred.at(1, 5, 4), blurred.at(1, 4, 3));
}

TEST(GaussianBlur, RefusesAWidthThatIsNone) {
  const Image image(3, 3, 3);
  for (const double sigma :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    EXPECT_NE(message_of([&] { gaussian_blur(image, sigma); }).find("expected a number above 0"),
              std::string::npos);
}

}  // namespace
}  // namespace ld
