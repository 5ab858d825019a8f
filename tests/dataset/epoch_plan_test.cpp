#include "dataset/epoch_plan.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "core/error.h"
#include "core/random.h"

namespace ld {
namespace {

TEST(EpochPlan, OneSetIsOneShuffleOfItsFrames) {
  const EpochPlan plan({7}, 7, {3}, 5);
  ASSERT_EQ(plan.crops(), 7u);
  std::set<std::vector<size_t>> orders;
  for (uint32_t epoch = 0; epoch < 4; ++epoch) {
    RandomStream stream(5, RandomPurpose::data_order, epoch);
    const std::vector<uint32_t> expected = random_permutation(stream, 7);
    std::vector<size_t> order;
    for (const ClipRef& ref : plan.epoch(epoch)) order.push_back(ref.clip);
    EXPECT_EQ(order, std::vector<size_t>(expected.begin(), expected.end()));
    orders.insert(order);
  }
  EXPECT_GT(orders.size(), 2u);
}

TEST(EpochPlan, SetsGetTheirSharesSpreadEvenly) {
  const EpochPlan plan({30, 6, 4}, 40, {1, 2, 1}, 1);
  ASSERT_EQ(plan.crops(), 40u);
  for (uint32_t epoch = 0; epoch < 3; ++epoch) {
    const std::vector<ClipRef> refs = plan.epoch(epoch);
    ASSERT_EQ(refs.size(), 40u);
    for (size_t batch = 0; batch < 10; ++batch) {
      int counts[3] = {};
      for (size_t slot = 0; slot < 4; ++slot) ++counts[refs[4 * batch + slot].set];
      EXPECT_EQ(counts[0], 1);
      EXPECT_EQ(counts[1], 2);
      EXPECT_EQ(counts[2], 1);
    }
  }
}

TEST(EpochPlan, EveryFrameHasItsTurnBeforeAnyHasItsNext) {
  const EpochPlan plan({12, 5}, 17, {1, 1}, 3);
  std::map<std::pair<size_t, size_t>, int> seen;
  for (uint32_t epoch = 0; epoch < 20; ++epoch) {
    for (const ClipRef& ref : plan.epoch(epoch)) {
      ASSERT_LT(ref.clip, ref.set == 0 ? 12u : 5u);
      ++seen[{ref.set, ref.clip}];
    }
    for (size_t set = 0; set < 2; ++set) {
      int low = 1000, high = 0;
      for (size_t frame = 0; frame < (set == 0 ? 12u : 5u); ++frame) {
        low = std::min(low, seen[{set, frame}]);
        high = std::max(high, seen[{set, frame}]);
      }
      EXPECT_LE(high - low, 1) << "epoch " << epoch << ", set " << set;
    }
  }
}

TEST(EpochPlan, AnEpochMayTakeAFewOfTheClipsUntilAllHaveHadTheirTurn) {
  const EpochPlan plan({10}, 4, {1}, 3);
  std::map<size_t, int> seen;
  for (uint32_t epoch = 0; epoch < 5; ++epoch) {
    ASSERT_EQ(plan.epoch(epoch).size(), 4u);
    for (const ClipRef& ref : plan.epoch(epoch)) ++seen[ref.clip];
    if (epoch == 1) {
      EXPECT_EQ(seen.size(), 8u);
    }
  }
  ASSERT_EQ(seen.size(), 10u);
  for (const auto& [clip, times] : seen) EXPECT_EQ(times, 2) << clip;
}

TEST(EpochPlan, AShareOfNothingIsAnError) {
  EXPECT_THROW(EpochPlan({5, 5}, 10, {1, 0.01}, 1), UsageError);
  EXPECT_EQ(EpochPlan({5, 500}, 505, {1, 0.01}, 1).crops(), 505u);
}

}  // namespace
}  // namespace ld
