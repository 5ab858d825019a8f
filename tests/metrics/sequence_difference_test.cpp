// The warped difference of neighbouring frames and its gradient.
#include "metrics/sequence_difference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/random.h"
#include "metrics/detail_filter.h"

namespace ld {
namespace {

constexpr int kWide = 7, kHigh = 5;

std::vector<double> random_planes(uint32_t number, double scale = 1) {
  RandomStream stream(7, RandomPurpose::test, number);
  std::vector<double> planes(size_t(3 * kWide * kHigh));
  for (double& x : planes) x = scale * stream.uniform();
  return planes;
}

/// Fractional motion, one pixel in three without a past, and taps whose weights do not tell their order.
Warp awkward_warp() {
  Warp warp;
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x) {
      Reprojection place;
      place.taps = bilinear_taps(static_cast<float>(x) - 0.3F, static_cast<float>(y) + 0.6F, kWide, kHigh);
      float sum = 0;
      for (const BilinearTap& tap : place.taps) sum += tap.weight;
      place.valid = (x + y) % 3 != 0;
      for (BilinearTap& tap : place.taps) tap.weight /= sum;
      warp.push_back(place);
    }
  return warp;
}

TEST(SequenceDifference, TheGradientIsThatOfFiniteDifferences) {
  for (const TemporalNorm norm : {TemporalNorm::absolute, TemporalNorm::squared, TemporalNorm::relative}) {
    std::vector<double> now = random_planes(1), before = random_planes(2);
    const std::vector<double> r_now = random_planes(3), r_before = random_planes(4);
    const Warp warp = awkward_warp();
    const auto value = [&] {
      return temporal_error<double>(norm, {now, before, r_now, r_before}, warp, kWide);
    };
    std::vector<double> now_slope(now.size()), before_slope(before.size());
    add_temporal_gradient<double>(norm, {now, before, r_now, r_before}, warp, kWide, 3, now_slope,
                                  before_slope);
    constexpr double step = 1e-6;
    for (auto* planes : {&now, &before})
      for (size_t i = 0; i < planes->size(); ++i) {
        const double kept = (*planes)[i];
        (*planes)[i] = kept + step;
        const double above = value();
        (*planes)[i] = kept - step;
        const double below = value();
        (*planes)[i] = kept;
        EXPECT_NEAR((planes == &now ? now_slope : before_slope)[i], 3 * (above - below) / (2 * step), 1e-6)
            << "norm " << static_cast<int>(norm) << ", value " << i;
      }
  }
}

TEST(SequenceDifference, TheValueIsThatOfPlainLoops) {
  const std::vector<double> now = random_planes(1), before = random_planes(2), r_now = random_planes(3),
                            r_before = random_planes(4);
  const Warp warp = awkward_warp();
  const std::vector<double> past = warped(before, warp, kWide), r_past = warped(r_before, warp, kWide);
  double absolute = 0, squared = 0, relative = 0;
  int count = 0;
  for (size_t i = 0; i < now.size(); ++i) {
    if (!warp[i % warp.size()].valid) continue;
    const double b = r_now[i] - r_past[i], e = now[i] - past[i] - b;
    absolute += std::abs(e);
    squared += e * e;
    relative += std::abs(e) / (std::abs(b) + 0.01);
    ++count;
  }
  const TemporalPictures<double> pictures{now, before, r_now, r_before};
  EXPECT_NEAR(temporal_error(TemporalNorm::absolute, pictures, warp, kWide), absolute / count, 1e-14);
  EXPECT_NEAR(temporal_error(TemporalNorm::squared, pictures, warp, kWide), squared / count, 1e-14);
  EXPECT_NEAR(temporal_error(TemporalNorm::relative, pictures, warp, kWide), relative / count, 1e-12);
}

TEST(SequenceDifference, TheLookupReproducesALinearRamp) {
  std::vector<double> ramp(size_t(kWide * kHigh));
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x) ramp[size_t(y * kWide + x)] = 2 * x - 3 * y;
  const Warp warp = awkward_warp();
  const std::vector<double> found = warped(ramp, warp, kWide);
  const size_t inner = 2 * kWide + 3;
  ASSERT_TRUE(warp[inner].valid);
  EXPECT_NEAR(found[inner], 2 * 2.7 - 3 * 2.6, 1e-5);
}

TEST(SequenceDifference, WhatWasNotSeenMayBeAnything) {
  std::vector<float> now(3, 1), before(3, std::numeric_limits<float>::quiet_NaN());
  const std::vector<float> reference(3, 1);
  Warp warp(1);
  const TemporalPictures<float> pictures{now, before, reference, reference};
  EXPECT_TRUE(std::isnan(temporal_error(TemporalNorm::absolute, pictures, warp, 1)));
  std::vector<float> a(3), b(3);
  add_temporal_gradient(TemporalNorm::absolute, pictures, warp, 1, 1, a, b);
  EXPECT_EQ(a, std::vector<float>(3));
  EXPECT_EQ(b, std::vector<float>(3));
  EXPECT_EQ(warped(before, warp, 1), std::vector<float>(3));
  for (const float extreme : {3e38F, -3e38F, 65504.0F, std::numeric_limits<float>::denorm_min()}) {
    const std::vector<float> picture(3, extreme), other(3, -extreme);
    const double error = temporal_error<float>(TemporalNorm::squared, {picture, other, reference, reference},
                                               identity_warp(1, 1), 1);
    EXPECT_NEAR(error / (4 * double{extreme} * double{extreme}), 1, 1e-6);
  }
}

TEST(DetailFilter, IsTheUsualKernel) {
  const auto at = [](int x, int y) { return detail_kernel()[size_t((y + 7) * kDetailWindow + x + 7)]; };
  EXPECT_NEAR(at(0, 0), -0.0628760, 5e-8);
  EXPECT_NEAR(at(1, 0), -0.0391589, 5e-8);
  EXPECT_NEAR(at(0, 2), -0.0028721, 5e-8);
  EXPECT_NEAR(at(-3, 0), 0.0085094, 5e-8);
  double sum = 0, size = 0;
  for (const double weight : detail_kernel()) {
    sum += weight;
    size += std::abs(weight);
  }
  EXPECT_NEAR(sum, 0, 1e-15);
  EXPECT_NEAR(size, 0.641177, 5e-7);
  std::vector<double> parabola(15 * 16);
  for (size_t i = 0; i < parabola.size(); ++i) parabola[i] = double(i % 16) * double(i % 16);
  const std::vector<double> found = fine_detail(parabola, 16, 15);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0], 1.99987, 5e-6);
  EXPECT_NEAR(found[1], 1.99987, 5e-6);
  EXPECT_TRUE(fine_detail(parabola, 14, 15).empty());
}

}  // namespace
}  // namespace ld
