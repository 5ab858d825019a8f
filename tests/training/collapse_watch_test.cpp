// The watch on synthetic losses: what is a collapse, after how many steps, and what is none.
#include "training/run/collapse_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/random.h"

namespace ld {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The step that finds a collapse of the losses, which scatter by +-30 %; 0: none in so many steps.
int64_t found_at(const std::function<double(int64_t)>& loss, int64_t steps, WatchState state = {},
                 const WatchConfig& config = {}) {
  for (int64_t step = 1; step <= steps; ++step) {
    RandomStream stream(1, RandomPurpose::test, static_cast<uint32_t>(step));
    if (watch_loss(state, config, loss(step) * (0.7 + 0.6 * stream.uniform()), step)) return step;
  }
  return 0;
}

/// From 1 down to 0.067, most of it in the first 200 steps.
double descent(int64_t step) {
  return 0.067 + std::exp(-static_cast<double>(step) / 60);
}

TEST(CollapseWatch, AJumpThatStaysIsFoundInTime) {
  for (int64_t jump = 1000; jump < 1025; ++jump) {
    const int64_t found = found_at([=](int64_t step) { return step < jump ? descent(step) : 0.18; }, 2000);
    EXPECT_GT(found, jump + 75);
    EXPECT_LE(found, jump + 125);  // patience + 1 windows
  }
}

TEST(CollapseWatch, AJumpThatTakesFiftyStepsIsFoundToo) {
  const auto loss = [](int64_t step) {
    const double up = std::min(std::max(static_cast<double>(step - 1000) / 50, 0.0), 1.0);
    return 0.067 + up * (0.18 - 0.067);
  };
  const int64_t found = found_at(loss, 2000);
  EXPECT_GT(found, 1000);
  EXPECT_LE(found, 1175);
}

TEST(CollapseWatch, TheCalmStepIsFromBeforeTheJump) {
  for (int64_t jump = 1000; jump < 1025; ++jump) {
    WatchState state;
    int64_t step = 1;
    while (!watch_loss(state, {}, step < jump ? 0.067 : 0.18, step)) ASSERT_LT(++step, 2000);
    EXPECT_LT(state.calm_step, jump);
    EXPECT_GT(state.calm_step, jump - 75);
  }
}

TEST(CollapseWatch, WhatPassesIsNone) {
  for (const int64_t length : {1, 10, 50, 74})
    for (const double height : {0.18, 50.0, 1e30})
      EXPECT_EQ(
          found_at(
              [=](int64_t step) { return step > 1000 && step <= 1000 + length ? height : descent(step); },
              3000),
          0)
          << length << " steps of " << height;
}

TEST(CollapseWatch, ASlowDriftIsNone) {
  EXPECT_EQ(found_at([](int64_t step) { return 0.067 * std::exp2(static_cast<double>(step) / 2000); }, 20000),
            0);
  EXPECT_EQ(found_at([](int64_t step) { return step < 1000 ? 0.067 : 0.085; }, 20000), 0) << "a small jump";
}

TEST(CollapseWatch, TheFirstDescentIsNone) {
  EXPECT_EQ(found_at(descent, 20000), 0);
  EXPECT_EQ(found_at([](int64_t step) { return 1e6 / static_cast<double>(step); }, 20000), 0);
  // A rise before the descent, as of a network that begins badly.
  EXPECT_EQ(found_at([](int64_t step) { return step < 60 ? 0.5 : 3 * descent(step); }, 20000), 0);
}

TEST(CollapseWatch, StepsWithoutALossCountForNothing) {
  const auto loss = [](int64_t step) { return step < 1000 ? 0.067 : 0.18; };
  const int64_t whole = found_at(loss, 2000);
  ASSERT_GT(whole, 0);
  // The same losses with two steps that were not taken after each.
  WatchState state;
  WatchConfig config;
  int64_t taken = 0, found = 0;
  for (int64_t step = 1; step <= 6000 && found == 0; ++step) {
    if (step % 3 != 1) {
      EXPECT_FALSE(watch_loss(state, config, step % 3 == 2 ? kNaN : kInfinity, step));
      continue;
    }
    RandomStream stream(1, RandomPurpose::test, static_cast<uint32_t>(++taken));
    if (watch_loss(state, config, loss(taken) * (0.7 + 0.6 * stream.uniform()), step)) found = taken;
  }
  EXPECT_EQ(found, whole);
}

TEST(CollapseWatch, ExtremeLosses) {
  EXPECT_EQ(found_at([](int64_t) { return 0.0; }, 1000), 0);
  EXPECT_EQ(found_at([](int64_t step) { return step < 500 ? 0.0 : 1.0; }, 2000), 0)
      << "nothing is a multiple of 0";
  EXPECT_EQ(found_at([](int64_t) { return 3e38; }, 1000), 0);
  EXPECT_GT(found_at([](int64_t step) { return step < 500 ? 1e-38 : 3e38; }, 1000), 500);
  EXPECT_GT(found_at([](int64_t step) { return step < 500 ? 5e-324 : 1.0; }, 1000), 500);
  EXPECT_EQ(found_at([](int64_t) { return -1.0; }, 1000), 0);
}

TEST(CollapseWatch, KeysDecide) {
  const auto loss = [](int64_t step) { return step < 1000 ? 0.067 : 0.18; };
  WatchConfig config;
  config.loss_factor = 4;
  EXPECT_EQ(found_at(loss, 5000, {}, config), 0);
  config = {};
  config.window = 1;
  config.patience = 10;
  EXPECT_EQ(found_at(loss, 5000, {}, config), 1009);
}

TEST(CollapseWatch, AWindowThatWasMadeShorterMeanwhileEndsAtOnce) {
  WatchState state;
  state.losses.assign(60, 1.0);
  EXPECT_FALSE(watch_loss(state, {}, 1.0, 61));
  EXPECT_TRUE(state.losses.empty());
  EXPECT_EQ(state.medians.size(), 1u);
}

}  // namespace
}  // namespace ld
