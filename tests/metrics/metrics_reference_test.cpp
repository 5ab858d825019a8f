// The metrics against plain loops, values computed by hand, and scikit-image.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "metrics/metric.h"
#include "metrics/psnr.h"
#include "metrics/relmse.h"
#include "metrics/smape.h"
#include "metrics/ssim.h"
#include "plain_metrics.h"

namespace ld {
namespace {

Image constant(int width, int height, float value) {
  Image image(width, height, 3);
  for (float& x : image.pixels) x = value;
  return image;
}

/// Radiance whose display value is `shown`: eq. 8 and 7 backwards, for shown > 0.04045.
float radiance_shown_as(double shown) {
  return static_cast<float>(std::expm1(std::pow((shown + 0.055) / 1.055, 2.4)));
}

TEST(MetricsReference, EveryMetricAgreesWithPlainLoopsAtAwkwardSizes) {
  const std::map<std::string, double (*)(const Image&, const Image&)> loops = {
      {"relmse", plain::relmse}, {"smape", plain::smape}, {"psnr", plain::psnr}, {"ssim", plain::ssim}};
  uint32_t number = 0;
  for (const auto& [width, height] : {std::pair{1, 1},
                                      {1, 2},
                                      {2, 1},
                                      {3, 3},
                                      {4, 7},
                                      {10, 10},
                                      {11, 11},
                                      {12, 11},
                                      {31, 33},
                                      {5, 40},
                                      {40, 2}}) {
    SCOPED_TRACE(testing::Message() << width << "x" << height);
    const Image reference = plain::random_image(width, height, ++number);
    for (const double amount : {0.01, 0.5, 3.0}) {
      Image denoised = plain::with_noise(reference, amount, number);
      denoised.pixels.back() += 0.25F;  // so that an all-black pair still differs
      for (const Metric& metric : metrics()) {
        ASSERT_EQ(loops.count(metric.name), 1u) << "no plain loops for " << metric.name;
        const double expected = loops.at(metric.name)(denoised, reference);
        EXPECT_NEAR(metric.compute(denoised, reference), expected, 1e-11 * std::max(1.0, expected))
            << metric.name;
      }
    }
  }
}

TEST(MetricsReference, ConstantPicturesGiveTheValuesComputedByHand) {
  const Image half = constant(13, 12, 0.5F), quarter = constant(13, 12, 0.25F);
  EXPECT_NEAR(relmse(half, quarter), 0.0625 / (0.0625 + 1e-4), 1e-13);
  EXPECT_NEAR(smape(half, quarter), 0.25 / 0.76, 1e-13);
  // Display values 0.8 and 0.6: PSNR 10 log10(1 / 0.04); SSIM without variance is its luminance term alone.
  const Image bright = constant(13, 12, radiance_shown_as(0.8)),
              dark = constant(13, 12, radiance_shown_as(0.6));
  EXPECT_NEAR(psnr(bright, dark), 13.979400086720377, 1e-5);
  EXPECT_NEAR(ssim(bright, dark), (2 * 0.8 * 0.6 + 1e-4) / (0.64 + 0.36 + 1e-4), 1e-6);
  // Against black only the epsilons remain.
  const Image black = constant(13, 12, 0);
  EXPECT_NEAR(relmse(half, black), 0.25 / 1e-4, 1e-9);
  EXPECT_NEAR(smape(half, black), 0.5 / 0.51, 1e-13);
  EXPECT_NEAR(ssim(bright, black), 1e-4 / (0.64 + 1e-4), 1e-9);
}

TEST(MetricsReference, OneDifferentChannelOfOnePixelCountsAsItsShareOfTheMean) {
  const Image reference = constant(5, 4, 1.0F);
  Image denoised = reference;
  denoised.at(2, 3, 1) = 3.0F;
  EXPECT_NEAR(relmse(denoised, reference), 4 / (1 + 1e-4) / 60, 1e-13);
  EXPECT_NEAR(smape(denoised, reference), 2 / 4.01 / 60, 1e-13);
  const double difference = 1 - (1.055 * std::pow(std::log(2.0), 1 / 2.4) - 0.055);  // 3 is shown as 1
  EXPECT_NEAR(psnr(denoised, reference), -10 * std::log10(difference * difference / 60), 1e-10);
}

// Made with scikit-image 0.26.0 and numpy 2.4.6 (Python), in double, from the same two formulas as below:
//   c, y, x = meshgrid(arange(3), arange(h), arange(w), indexing="ij")
//   r = ((x*x*37 + y*y*101 + x*y*3 + c*59) % 256) / 128 * ((x//8 + y//8) % 3 + 1) / 2
//   d = maximum(r + ((x*7 + y*13 + x*y*5 + c*3) % 17 - 8) / 32, 0)
//   tm(v): u = log1p(v); minimum(where(u <= 0.0031308, 12.92*u, 1.055*u**(1/2.4) - 0.055), 1)
//   structural_similarity(tm(r), tm(d), win_size=11, gaussian_weights=True, sigma=1.5,
//   use_sample_covariance=False,
//                         data_range=1.0, channel_axis=0)
//   peak_signal_noise_ratio(tm(r), tm(d), data_range=1.0)
//   mean((d - r)**2 / (r*r + 1e-4)), mean(abs(d - r) / (abs(d) + abs(r) + 0.01))
struct Expected {
  int width, height;
  double relmse, smape, ssim, psnr;
};
constexpr Expected kScikitImage[] = {
    {31, 33, 1.52549177731877, 0.151896228904696, 0.900435389537021, 19.5816218804974},
    {64, 48, 1.67281702046372, 0.145863195915668, 0.899547021032216, 19.7829544283187},
    {11, 11, 1.53075459661383, 0.168972624613279, 0.846868992806174, 19.5603391905735},
    {17, 12, 1.37144751666532, 0.155279437448743, 0.899693715807335, 19.8166934778885},
};

TEST(MetricsReference, AgreesWithScikitImage) {
  for (const Expected& expected : kScikitImage) {
    SCOPED_TRACE(testing::Message() << expected.width << "x" << expected.height);
    Image r(expected.width, expected.height, 3), d(expected.width, expected.height, 3);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < r.height; ++y)
        for (int x = 0; x < r.width; ++x) {
          const int texture = (x * x * 37 + y * y * 101 + x * y * 3 + c * 59) % 256;
          const int tile = (x / 8 + y / 8) % 3 + 1;
          const int noise = (x * 7 + y * 13 + x * y * 5 + c * 3) % 17 - 8;
          r.at(c, x, y) =
              static_cast<float>(texture) / 128.0F * static_cast<float>(tile) / 2.0F;  // exact in float
          d.at(c, x, y) = std::max(r.at(c, x, y) + static_cast<float>(noise) / 32.0F, 0.0F);
        }
    EXPECT_NEAR(relmse(d, r), expected.relmse, 1e-12);
    EXPECT_NEAR(smape(d, r), expected.smape, 1e-13);
    EXPECT_NEAR(ssim(d, r), expected.ssim, 1e-12);
    EXPECT_NEAR(psnr(d, r), expected.psnr, 1e-11);
  }
}

}  // namespace
}  // namespace ld
