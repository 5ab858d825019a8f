#include "metrics/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/random.h"

#include "tests/support/special_values.h"

namespace ld {
namespace {

TEST(Statistics, StudentsLimitsAreThoseOfTheTables) {
  // Two-sided 95 %, as printed in Abramowitz and Stegun, table 26.10.
  const std::pair<int, double> table[] = {{1, 12.706}, {2, 4.303},  {3, 3.182},  {4, 2.776},  {5, 2.571},
                                          {9, 2.262},  {10, 2.228}, {29, 2.045}, {30, 2.042}, {120, 1.980}};
  for (const auto& [degrees, limit] : table) EXPECT_NEAR(student_t_limit(degrees), limit, 5.1e-4) << degrees;
  EXPECT_NEAR(student_t_limit(100'000), 1.959988, 1e-5);
}

TEST(Statistics, IntervalsOfMeans) {
  // Mean 3, deviation sqrt(2.5), 4 degrees of freedom.
  const auto interval = mean_interval({1, 2, 3, 4, 5});
  ASSERT_TRUE(interval);
  EXPECT_NEAR(interval->low, 3 - 2.7764451 * std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(interval->high, 3 + 2.7764451 * std::sqrt(0.5), 1e-6);
  const auto constant = mean_interval({7, 7, 7});
  EXPECT_EQ(constant->low, 7);
  EXPECT_EQ(constant->high, 7);
  for (const std::vector<double>& values : {std::vector<double>{}, {1}, {1, kNan, 2}, {1, 2, kInfinite}})
    EXPECT_FALSE(mean_interval(values));
}

TEST(Statistics, IntervalsHoldTheTrueMeanAsOftenAsTheySay) {
  RandomStream stream(3, RandomPurpose::test);
  int held = 0;
  constexpr int kTrials = 4000;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> values(6);
    for (double& value : values) value = 10 + stream.normal();
    const auto interval = mean_interval(values);
    held += interval->low <= 10 && 10 <= interval->high;
  }
  EXPECT_NEAR(held / double(kTrials), kConfidence, 0.014);  // four deviations
}

/// Every choice of signs, counted: p is the share whose smaller rank sum is as small as the observed one.
double counted_p(const std::vector<double>& differences) {
  std::vector<double> values;
  for (const double x : differences)
    if (x != 0) values.push_back(x);
  const size_t n = values.size();
  std::vector<double> ranks(n);
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j < n; ++j)
      ranks[i] += std::abs(values[j]) < std::abs(values[i])   ? 1
                  : std::abs(values[j]) > std::abs(values[i]) ? 0
                  : i == j                                    ? 1
                                                              : 0.5;
  const auto smaller_sum = [&](auto is_positive) {
    double positive = 0, negative = 0;
    for (size_t i = 0; i < n; ++i) (is_positive(i) ? positive : negative) += ranks[i];
    return std::min(positive, negative);
  };
  const double observed = smaller_sum([&](size_t i) { return values[i] > 0; });
  int as_small = 0;
  for (unsigned signs = 0; signs < 1U << n; ++signs)
    as_small += smaller_sum([&](size_t i) { return (signs >> i & 1U) != 0; }) <= observed;
  return as_small / std::exp2(double(n));
}

TEST(Statistics, TheSignedRankTestCountsEveryChoiceOfSigns) {
  RandomStream stream(4, RandomPurpose::test);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> differences(1 + stream.below(10));
    for (double& x : differences)
      x = trial % 2 == 0 ? stream.normal() + 0.5 : double(stream.below(7)) - 2;  // with ties and zeros
    const auto p = signed_rank_p(differences);
    bool any = false;
    for (const double x : differences) any = any || x != 0;
    ASSERT_EQ(p.has_value(), any);
    if (any) {
      ASSERT_NEAR(*p, counted_p(differences), 1e-12) << trial;
    }
  }
}

TEST(Statistics, SixEqualSignsAreTheFirstToBeSignificant) {
  EXPECT_DOUBLE_EQ(*signed_rank_p({1, 2, 3, 4, 5}), 2.0 / 32);
  EXPECT_DOUBLE_EQ(*signed_rank_p({-1, -2, -3, -4, -5, -6}), 2.0 / 64);
  EXPECT_EQ(kFewestFrames, 6);
  EXPECT_DOUBLE_EQ(*signed_rank_p({3, -3}), 1);
}

TEST(Statistics, ManyDifferencesTakeTheNormalApproximation) {
  std::vector<double> differences;
  for (int i = 1; i <= 60; ++i) differences.push_back(i % 3 == 0 ? -i : i);
  // scipy.stats.wilcoxon(differences, mode="approx") of SciPy 1.10.1.
  EXPECT_NEAR(*signed_rank_p(differences), 0.03590012321587811, 1e-12);
}

TEST(Statistics, NothingToRankHasNoP) {
  for (const std::vector<double>& values : {std::vector<double>{}, {0, 0}, {1, kNan}, {kInfinite, 1}})
    EXPECT_FALSE(signed_rank_p(values));
}

}  // namespace
}  // namespace ld
