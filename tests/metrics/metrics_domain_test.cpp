// The edges of the metrics' domain: nothing overflows, nothing vanishes, nothing is hidden.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "core/error.h"
#include "metrics/image_pair.h"
#include "metrics/metric.h"
#include "metrics/psnr.h"
#include "metrics/relmse.h"
#include "metrics/smape.h"
#include "metrics/ssim.h"
#include "plain_metrics.h"
#include "tests/support/expect_error.h"

namespace ld {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kDenormal = std::numeric_limits<float>::denorm_min();

Image pixel(float red, float green, float blue) {
  Image image(1, 1, 3);
  image.pixels = {red, green, blue};
  return image;
}

TEST(MetricsDomain, ExtremeRadianceGivesFiniteNumbersThatAreRight) {
  for (const float extreme : {0.0F, kDenormal, 1e-38F, 65504.0F, 3e38F, -1.0F, -3e38F})
    for (const float other : {0.0F, kDenormal, 1e-38F, 1.0F, 65504.0F, 3e38F}) {
      SCOPED_TRACE(testing::Message() << extreme << " against " << other);
      const Image d = pixel(extreme, 0.5F, 0.25F), r = pixel(other, 0.25F, 0.25F);
      EXPECT_NEAR(relmse(d, r) / plain::relmse(d, r), 1, 1e-12);
      EXPECT_NEAR(smape(d, r), plain::smape(d, r), 1e-13);
      EXPECT_NEAR(psnr(d, r), plain::psnr(d, r), 1e-10);
      EXPECT_NEAR(ssim(d, r), plain::ssim(d, r), 1e-12);
    }
}

TEST(MetricsDomain, AFireflyOnBlackKeepsItsMagnitude) {
  const Image black = pixel(0, 0, 0);
  EXPECT_NEAR(relmse(pixel(65504, 65504, 65504), black) / (65504.0 * 65504.0 * 1e4), 1, 1e-15);
  const double huge = 3e38F;
  EXPECT_NEAR(relmse(pixel(3e38F, 3e38F, 3e38F), black) / (huge * huge * 1e4), 1, 1e-15);
  EXPECT_LT(smape(pixel(3e38F, 0, 0), black), 1.0 / 3 + 1e-15);
}

TEST(MetricsDomain, DenormalsAreNotFlushedAway) {
  const Image black = pixel(0, 0, 0);
  const double tiny = kDenormal;  // its square is a normal double
  EXPECT_NEAR(relmse(pixel(kDenormal, 0, 0), black) / (tiny * tiny * 1e4 / 3), 1, 1e-12);
  EXPECT_NEAR(smape(pixel(kDenormal, 0, 0), black) / (tiny * 100 / 3), 1, 1e-12);
  EXPECT_GT(psnr(pixel(kDenormal, 0, 0), black), 800);
  EXPECT_TRUE(std::isfinite(psnr(pixel(kDenormal, 0, 0), black)));
}

TEST(MetricsDomain, NegativeValuesAreSeenByTheLinearMetricsAndBlackToTheOthers) {
  const Image black = pixel(0, 0, 0), negative = pixel(-2, -2, -2);
  EXPECT_NEAR(relmse(negative, black), 4e4, 1e-8);
  EXPECT_NEAR(smape(negative, black), 2 / 2.01, 1e-15);
  EXPECT_EQ(psnr(negative, black), std::numeric_limits<double>::infinity());
  EXPECT_EQ(ssim(negative, black), 1);
}

TEST(MetricsDomain, EqualPicturesHaveInfinitePsnr) {
  const Image image = plain::random_image(9, 7, 1);
  EXPECT_EQ(psnr(image, image), std::numeric_limits<double>::infinity());
}

TEST(MetricsDomain, OneBadValueAnywhereInTheDenoisedPictureShowsInEveryMetric) {
  const Image reference = plain::random_image(31, 33, 2);
  for (const Metric& metric : metrics())
    for (const float bad : {kNan, -kNan, kInfinity, -kInfinity})
      for (const size_t where : {size_t(0), size_t(31 * 33 + 500), reference.pixels.size() - 1}) {
        Image denoised = reference;
        denoised.pixels[where] = bad;
        EXPECT_TRUE(std::isnan(metric.compute(denoised, reference)))
            << metric.name << " of " << bad << " at " << where;
        EXPECT_EQ(count_not_finite(denoised), 1);
      }
}

TEST(MetricsDomain, ABadReferenceIsAnErrorWithTheCount) {
  const Image denoised = plain::random_image(3, 3, 3);
  Image reference = denoised;
  reference.pixels[4] = kNan;
  reference.pixels[5] = kInfinity;
  for (const Metric& metric : metrics()) {
    const std::string message = error_text([&] { metric.compute(denoised, reference); });
    EXPECT_NE(message.find("reference picture holds 2 NaN"), std::string::npos)
        << metric.name << ": " << message;
  }
}

TEST(MetricsDomain, PicturesThatCannotBeComparedAreErrorsThatNameWhatWasFound) {
  const Image good(4, 3, 3), turned(3, 4, 3), grey(4, 3, 1), empty;
  Image short_of_pixels(4, 3, 3);
  short_of_pixels.pixels.resize(7);
  for (const Metric& metric : metrics()) {
    SCOPED_TRACE(metric.name);
    EXPECT_NE(error_text([&] { metric.compute(turned, good); }).find("3x4, its reference 4x3"),
              std::string::npos);
    EXPECT_NE(error_text([&] { metric.compute(grey, good); }).find("denoised picture has 1 channels"),
              std::string::npos);
    EXPECT_NE(error_text([&] { metric.compute(good, grey); }).find("reference picture has 1 channels"),
              std::string::npos);
    EXPECT_NE(error_text([&] { metric.compute(empty, empty); }).find("denoised picture"), std::string::npos);
    EXPECT_NE(error_text([&] { metric.compute(Image(0, 3, 3), good); }).find("at least one pixel"),
              std::string::npos);
    EXPECT_NE(error_text([&] { metric.compute(short_of_pixels, good); }).find("holds 7 values"),
              std::string::npos);
  }
}

TEST(MetricsDomain, AnUnknownNameGetsTheNearestAndTheList) {
  EXPECT_EQ(find_metric("ssim").title, "SSIM");
  const std::string message = error_text([] { find_metric("relmes"); });
  EXPECT_NE(message.find("did you mean 'relmse'?"), std::string::npos) << message;
  EXPECT_NE(message.find("relmse, smape, ssim, psnr"), std::string::npos) << message;
}

}  // namespace
}  // namespace ld
