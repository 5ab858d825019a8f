#include "dataset/sample_draw.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace ld {
namespace {

constexpr int kDraws = 40000;

/// How often each number of the range is drawn, of 1.
std::map<int, double> shares(const SampleRange& range) {
  std::map<int, double> found;
  for (uint32_t i = 0; i < kDraws; ++i) {
    RandomStream stream(1, RandomPurpose::test, i);
    found[draw_sample_count(stream, range)] += 1.0 / kDraws;
  }
  return found;
}

TEST(SampleCount, EveryOctaveAndEveryNumberInItIsEquallyLikely) {
  struct Case {
    SampleRange range;
    std::map<int, double> expected;
  };
  const std::vector<Case> cases = {
      {{1, 1}, {{1, 1}}},
      {{6, 6}, {{6, 1}}},
      {{1, 3}, {{1, 1 / 2.0}, {2, 1 / 4.0}, {3, 1 / 4.0}}},
      {{1, 8}, {{1, .25}, {2, .125}, {3, .125}, {4, .0625}, {5, .0625}, {6, .0625}, {7, .0625}, {8, .25}}},
      {{3, 5}, {{3, 1 / 2.0}, {4, 1 / 4.0}, {5, 1 / 4.0}}},
      {{4, 7}, {{4, .25}, {5, .25}, {6, .25}, {7, .25}}}};
  for (const Case& one : cases) {
    SCOPED_TRACE(testing::Message() << one.range.least << " to " << one.range.most);
    const std::map<int, double> found = shares(one.range);
    ASSERT_EQ(found.size(), one.expected.size());
    double mean = 0;
    for (const auto& [count, share] : one.expected) {
      ASSERT_EQ(found.count(count), 1u) << count;
      EXPECT_NEAR(found.at(count), share, 0.01) << count;
      mean += count * share;
    }
    EXPECT_NEAR(mean_sample_count(one.range), mean, 1e-12);
  }
  EXPECT_EQ(shares({1, 64}).size(), 64u);
}

TEST(DrawnSamples, AreASetInOrderAndEverySetIsEquallyLikely) {
  std::map<SampleList, int> sets;
  for (uint32_t i = 0; i < kDraws; ++i) {
    RandomStream stream(2, RandomPurpose::test, i, 1);
    const SampleList drawn = draw_samples(stream, 5, 2);
    ASSERT_EQ(drawn.size(), 2u);
    ASSERT_LT(drawn[0], drawn[1]);
    ASSERT_GE(drawn[0], 0);
    ASSERT_LT(drawn[1], 5);
    ++sets[drawn];
  }
  ASSERT_EQ(sets.size(), 10u);
  for (const auto& [set, count] : sets) EXPECT_NEAR(count, kDraws / 10.0, 0.05 * kDraws / 10);
}

TEST(DrawnSamples, AllWhereThereAreNoMoreThanThat) {
  RandomStream stream(3, RandomPurpose::test);
  EXPECT_TRUE(draw_samples(stream, 4, 4).empty());
  EXPECT_TRUE(draw_samples(stream, 3, 8).empty());
  EXPECT_EQ(draw_samples(stream, 4, 1).size(), 1u);
}

TEST(DrawnSamples, TheSameStreamGivesTheSame) {
  for (uint32_t i = 0; i < 20; ++i) {
    RandomStream a(7, RandomPurpose::test, i, 3), b(7, RandomPurpose::test, i, 3);
    EXPECT_EQ(draw_samples(a, 64, 16), draw_samples(b, 64, 16));
  }
}

TEST(OtherSamples, AreTheRest) {
  EXPECT_EQ(other_samples(5, {0, 3}), (SampleList{1, 2, 4}));
  EXPECT_EQ(other_samples(3, {0, 1, 2}), SampleList());
  EXPECT_EQ(other_samples(2, {}), (SampleList{0, 1}));
}

}  // namespace
}  // namespace ld
