#include "metrics/floor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "metrics/metric.h"
#include "plain_metrics.h"
#include "tests/support/expect_error.h"

namespace ld {
namespace {

TEST(ReferenceFloor, OfEqualHalvesIsTheBestScore) {
  for (const float value : {0.0F, 1e-40F, 1e-38F, 0.5F, 65504.0F, 3e38F}) {
    Image half(1, 1, 3);
    half.pixels.assign(3, value);
    const ReferenceFloor floor = reference_floor(half, half);
    ASSERT_EQ(floor.size(), metrics().size());
    for (const Metric& metric : metrics()) EXPECT_EQ(floor.at(metric.name), metric.compute(half, half));
    EXPECT_EQ(floor.at("relmse"), 0);
    EXPECT_EQ(floor.at("psnr"), std::numeric_limits<double>::infinity());
  }
}

TEST(ReferenceFloor, IsAQuarterOfTheSquaredDifference) {
  Image first(20, 12, 3), second = first;
  first.pixels.assign(first.pixels.size(), 1.1F);
  second.pixels.assign(second.pixels.size(), 0.9F);
  const ReferenceFloor floor = reference_floor(first, second);
  EXPECT_NEAR(floor.at("relmse"), 0.2 * 0.2 / 4 / (1 + 1e-4), 1e-7);
  EXPECT_NEAR(floor.at("smape"), 0.1 / 2.01, 2e-4);
  // Half the difference: 6.02 dB more than one half against the other.
  EXPECT_NEAR(floor.at("psnr"), find_metric("psnr").compute(first, second) + 20 * std::log10(2.0), 0.1);
}

/// Every metric of the registry: the floor is what the mean of both halves scores against the truth.
TEST(ReferenceFloor, IsTheErrorOfTheMeanOfBothHalves) {
  const Image truth = plain::random_image(96, 96, 31);
  for (const double amount : {0.02, 0.1}) {
    const Image first = plain::with_noise(truth, amount, 32), second = plain::with_noise(truth, amount, 33);
    Image mean = first;
    for (size_t i = 0; i < mean.pixels.size(); ++i) mean.pixels[i] = (first.pixels[i] + second.pixels[i]) / 2;
    const ReferenceFloor floor = reference_floor(first, second);
    for (const Metric& metric : metrics()) {
      const double score = metric.compute(mean, truth), best = metric.compute(truth, truth);
      if (std::isinf(best))
        EXPECT_NEAR(floor.at(metric.name), score, 0.5) << metric.name;  // dB
      else
        EXPECT_NEAR((floor.at(metric.name) - best) / (score - best), 1, 0.1) << metric.name;
    }
  }
}

TEST(ReferenceFloor, IsEmptyForBrokenHalvesAndAnErrorForUnequalSizes) {
  Image half(2, 2, 3), broken = half;
  broken.pixels[5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(reference_floor(half, broken).empty());
  broken.pixels[5] = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(reference_floor(broken, half).empty());
  EXPECT_ERROR(reference_floor(half, Image(2, 3, 3)), "equal sizes");
}

}  // namespace
}  // namespace ld
