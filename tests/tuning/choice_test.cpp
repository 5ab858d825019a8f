// What pays, and which point is chosen.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.h"
#include "tuning/decisions.h"
#include "tuning/gain.h"

namespace ld {
namespace {

Point point(const std::string& name, double error, double ms, double unevenness = 0) {
  Point result;
  result.name = name;
  result.time.ms = ms;
  for (int frame = 0; frame < 8; ++frame)
    result.errors.push_back(error * (1 + 0.1 * frame) + (frame % 2 == 0 ? unevenness : -unevenness));
  result.error = mean_error(result.errors);
  return result;
}

const Requirement kWithin = {20.0, std::nullopt};

std::string chosen(const std::vector<Point>& points, const Requirement& requirement = kWithin) {
  const auto place = choose(points, requirement);
  return place ? points[*place].name : "";
}

TEST(TuningGain, IsSureWhereEveryFrameAgrees) {
  const Gain gain = gain_of(point("", 0.09, 1).errors, point("", 0.1, 1).errors);
  EXPECT_NEAR(gain.relative, 0.1, 1e-12);
  EXPECT_TRUE(gain.pays());
  EXPECT_FALSE(gain_of(point("", 0.1, 1).errors, point("", 0.09, 1).errors).pays());
  EXPECT_FALSE(gain_of(point("", 0.0999, 1).errors, point("", 0.1, 1).errors).pays());       // too little
  EXPECT_FALSE(gain_of(point("", 0.099, 1, 0.02).errors, point("", 0.1, 1).errors).pays());  // not sure
}

TEST(TuningGain, OfFewFramesIsJudgedByItsIntervalOrSize) {
  EXPECT_TRUE(gain_of({0.1, 0.2, 0.3}, {0.12, 0.22, 0.32}).sure);
  EXPECT_FALSE(gain_of({0.1, 0.2, 0.3}, {0.12, 0.19, 0.32}).sure);
  EXPECT_TRUE(gain_of({0.1}, {0.2}).sure);
  EXPECT_FALSE(gain_of({0.1}, {0.101}).sure);
  EXPECT_FALSE(gain_of({0, 0}, {0, 0}).pays());
  EXPECT_ERROR(gain_of({0.1}, {}), "the same frames");
}

TEST(TuningChoice, IsTheBestWithinTheBudget) {
  EXPECT_EQ(chosen({point("a", 0.1, 10), point("b", 0.05, 19), point("c", 0.01, 21)}), "b");
  EXPECT_EQ(chosen({point("a", 0.1, 21)}), "");
  EXPECT_EQ(chosen({point("a", std::nan(""), 10), point("b", 0.2, 10)}), "b");
}

TEST(TuningChoice, IsCheaperWhereTheBestGainsNothingThatPays) {
  EXPECT_EQ(chosen({point("a", 0.1001, 10), point("b", 0.1, 19)}), "a");
  EXPECT_EQ(chosen({point("a", 0.101, 10, 0.02), point("b", 0.1, 19)}), "a");
  EXPECT_EQ(chosen({point("a", 0.105, 10, 0.02), point("b", 0.1, 19)}), "b");  // too much to risk
  EXPECT_EQ(chosen({point("a", 0.102, 10), point("b", 0.1, 19)}), "b");
}

TEST(TuningChoice, IsOnTheFront) {
  for (double second = 0.09; second < 0.11; second += 0.0005)
    for (double ms = 5; ms < 20; ms += 2.5) {
      const std::vector<Point> points = {point("a", 0.1, 10), point("b", second, ms, 0.001),
                                         point("c", 0.1, 12), point("d", 0.1004, 10, 0.003)};
      const auto place = choose(points, kWithin);
      ASSERT_TRUE(place);
      for (const Point& other : points) EXPECT_FALSE(beats(other, points[*place])) << second << " " << ms;
    }
}

TEST(TuningChoice, WithATargetIsTheCheapest) {
  const Requirement target = {std::nullopt, 0.2};
  EXPECT_EQ(chosen({point("a", 0.1, 100), point("b", 0.13, 50), point("c", 0.3, 1)}, target), "b");
  EXPECT_EQ(chosen({point("c", 0.3, 1)}, target), "");
}

TEST(TuningChoice, TheBetterHalfIsRoundedUpAndWithoutFailures) {
  const std::vector<Point> points = {point("a", 0.3, 1), point("b", std::nan(""), 1), point("c", 0.1, 1),
                                     point("d", 0.2, 1), point("e", 0.4, 1)};
  EXPECT_EQ(better_half(points, kWithin), (std::vector<size_t>{2, 3, 0}));
  const Requirement target = {std::nullopt, 0.45};  // a, c and d are within: cheapest first
  std::vector<Point> priced = points;
  priced[0].time.ms = 0.5;
  EXPECT_EQ(better_half(priced, target), (std::vector<size_t>{0, 2, 3}));
}

}  // namespace
}  // namespace ld
