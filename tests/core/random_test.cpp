#include "core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace ld {
namespace {

TEST(Random, PhiloxMatchesTheKnownAnswersOfItsAuthors) {
  // kat_vectors of Random123, philox4x32 with 10 rounds.
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}),
            (std::array<uint32_t, 4>{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox4x32({~0U, ~0U, ~0U, ~0U}, {~0U, ~0U}),
            (std::array<uint32_t, 4>{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (std::array<uint32_t, 4>{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(Random, AStreamDependsOnItsKeyAlone) {
  RandomStream a(1, RandomPurpose::test, 2, 3, 4), b(1, RandomPurpose::test, 2, 3, 4);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(a.bits(), b.bits());
  std::set<uint32_t> first;
  first.insert(RandomStream(1, RandomPurpose::test, 2, 3, 4).bits());
  first.insert(RandomStream(2, RandomPurpose::test, 2, 3, 4).bits());
  first.insert(RandomStream(1, RandomPurpose::scene, 2, 3, 4).bits());
  first.insert(RandomStream(1, RandomPurpose::test, 3, 2, 4).bits());
  first.insert(RandomStream(1, RandomPurpose::test, 2, 3, 5).bits());
  EXPECT_EQ(first.size(), 5u);
}

TEST(Random, MomentsAreThoseOfTheDistribution) {
  RandomStream stream(5, RandomPurpose::test);
  const int n = 200000;
  double sum = 0, square = 0, normal_sum = 0, normal_square = 0;
  for (int i = 0; i < n; ++i) {
    const double u = stream.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    square += u * u;
    const double g = stream.normal();
    normal_sum += g;
    normal_square += g * g;
  }
  EXPECT_NEAR(sum / n, 0.5, 5 / std::sqrt(12.0 * n));
  EXPECT_NEAR(square / n, 1.0 / 3, 0.005);
  EXPECT_NEAR(normal_sum / n, 0, 5 / std::sqrt(double(n)));
  EXPECT_NEAR(normal_square / n, 1, 0.02);
}

TEST(Random, BelowAndPermutationCoverTheirRange) {
  RandomStream stream(6, RandomPurpose::test);
  std::array<int, 7> counts{};
  for (int i = 0; i < 70000; ++i) ++counts[stream.below(7)];
  for (const int count : counts) EXPECT_NEAR(count, 10000, 500);
  EXPECT_EQ(stream.below(1), 0u);
  std::vector<uint32_t> order = random_permutation(stream, 50);
  EXPECT_FALSE(std::is_sorted(order.begin(), order.end()));
  std::sort(order.begin(), order.end());
  for (uint32_t i = 0; i < 50; ++i) EXPECT_EQ(order[i], i);
}

}  // namespace
}  // namespace ld
