#include "tuning/halving.h"

#include <gtest/gtest.h>

namespace ld {
namespace {

TEST(TuningSchedule, TheMinutesAreSpentToTheLast) {
  for (const size_t candidates : {1, 2, 3, 7, 12, 28})
    for (const size_t groups : {0, 1, 3})
      EXPECT_NEAR(plan_search(candidates, groups, 60).minutes(), 60, 1e-9) << candidates << " " << groups;
}

TEST(TuningSchedule, EachRungHasTheBetterHalfForTwiceAsLong) {
  const SearchPlan plan = plan_search(13, 2, 60);
  std::vector<size_t> counts;
  for (size_t i = 0; i < plan.rungs.size(); ++i) {
    counts.push_back(plan.rungs[i].candidates);
    if (i > 0) {
      EXPECT_NEAR(plan.rungs[i].minutes, 2 * plan.rungs[i - 1].minutes, 1e-12);
    }
  }
  EXPECT_EQ(counts, (std::vector<size_t>{13, 7, 4, 2}));
  EXPECT_EQ(plan.feature_trials, 3);
  EXPECT_EQ(plan_search(13, 0, 60).feature_trials, 0);
}

TEST(TuningSchedule, OnlyAsManyTrainAsThereIsTimeFor) {
  EXPECT_EQ(affordable_candidates(30, 2, 1e4), 30);
  EXPECT_EQ(affordable_candidates(30, 2, 0.01), 2);
  EXPECT_EQ(affordable_candidates(1, 2, 0.01), 1);
  const size_t some = affordable_candidates(30, 2, 60);
  EXPECT_GT(some, 6);
  EXPECT_LT(some, 30);
  EXPECT_GE(plan_search(some, 2, 60).rungs[0].minutes, 0.5);
}

}  // namespace
}  // namespace ld
