// No interruption changes the course of a run: killed or stopped anywhere and continued, it ends the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <optional>

#include "tests/training/short_course.h"

namespace ld {
namespace {

/// A trainer whose weights are a sum over its steps, and whose checkpoints lie in memory. What it is told is
/// a function of step and rollbacks alone, as losses are.
struct Simulation {
  struct Checkpoint {
    TrainingState state;
    double weights = 0;
  };
  struct Row {
    double train_loss, validation_loss, weights;
    int64_t skipped, rollbacks;
    bool operator==(const Row& other) const {
      return train_loss == other.train_loss && validation_loss == other.validation_loss &&
             weights == other.weights && skipped == other.skipped && rollbacks == other.rollbacks;
    }
  };

  // The disk: what a killed process leaves behind.
  std::map<int64_t, Checkpoint> checkpoints;
  std::map<int64_t, Row> rows;

  // The network and its data.
  std::function<double(const TrainingState&)> loss = [](const TrainingState&) { return 1.0; };
  std::function<bool(int64_t step)> skips = [](int64_t) { return false; };
  std::function<double(int64_t step)> score = [](int64_t step) { return 1 / static_cast<double>(step); };
  std::function<bool(const TrainingState&)> has_room = [](const TrainingState&) { return true; };

  /// Runs from the newest checkpoint until the end, or until `reports` reports were made: then the process is
  /// killed, or asked to stop. Returns the state, or nothing when it was killed.
  std::optional<TrainingState> run(const RunConfig& config, int64_t steps, int reports = -1,
                                   bool gently = false) {
    RunCourse course(config, course_watch(), true);
    const Checkpoint newest = checkpoints.empty() ? Checkpoint{} : checkpoints.rbegin()->second;
    double weights = newest.weights;
    course.begin(newest.state, steps);
    rows.erase(rows.upper_bound(newest.state.validation_due ? newest.state.step - 1 : newest.state.step),
               rows.end());
    double validation = 0;  // of this step, not logged yet
    for (Next next = course.next(); next != Next::end; next = course.next()) {
      const TrainingState& state = course.state();
      if (reports-- == 0 && !gently) return std::nullopt;
      const bool stop = gently && reports < 0;
      if (next == Next::step && stop) {
        course.stop();
      } else if (next == Next::step) {
        course.step_begins();
        const int64_t number = state.step + 1;
        if (skips(number)) {
          course.step_skipped();
        } else {
          weights = weights / 2 + static_cast<double>(number) * state.rate_factor();
          course.step_taken(loss(state));
        }
      } else if (next == Next::validate && stop) {
        course.stop();
      } else if (next == Next::validate) {
        validation = score(state.step);
        course.validated(validation, kAnyKernels, kAnyDeviation);
      } else if (next == Next::log) {
        rows[state.step] = {state.loss_sum / static_cast<double>(std::max<int64_t>(state.loss_count, 1)),
                            validation, weights, state.skipped, state.rollbacks};
        validation = 0;
        course.logged();
      } else if (next == Next::save) {
        save(course, weights);
      } else {
        EXPECT_EQ(next, Next::go_back);
        const auto beyond = checkpoints.upper_bound(course.last_good_step());
        const Checkpoint good = beyond == checkpoints.begin() ? Checkpoint{} : std::prev(beyond)->second;
        checkpoints.erase(beyond, checkpoints.end());
        rows.erase(rows.upper_bound(good.state.step), rows.end());
        weights = good.weights;
        validation = 0;
        course.gone_back(good.state);
      }
    }
    if (course.saved_step() != course.state().step) save(course, weights);
    return course.state();
  }

  void save(RunCourse& course, double weights) {
    if (!has_room(course.state())) return course.not_saved();
    checkpoints[course.state().step] = {course.state(), weights};
    course.saved();
  }
};

/// The loss jumps at step 33 of a run that has not gone back, two steps are skipped, the best is at step 20.
Simulation eventful() {
  Simulation simulation;
  simulation.loss = [](const TrainingState& state) {
    return state.step >= 33 && state.rollbacks == 0 ? 3.0 : 1.0;
  };
  simulation.skips = [](int64_t step) { return step == 12 || step == 13 || step == 27; };
  simulation.score = [](int64_t step) { return step == 20 ? 0.25 : 0.5; };
  return simulation;
}

TEST(InterruptedCourse, KilledOrStoppedAnywhereItEndsTheSame) {
  Simulation straight = eventful();
  const std::optional<TrainingState> end = straight.run(course_run(), 60);
  ASSERT_TRUE(end);
  ASSERT_EQ(end->rollbacks, 1);
  ASSERT_EQ(end->skipped, 3);
  ASSERT_EQ(end->best_step, 20);
  ASSERT_EQ(straight.rows.size(), 12U);
  int kills = 0;
  for (const bool gently : {false, true})
    for (int reports = 0;; ++reports) {
      Simulation broken = eventful();
      const std::optional<TrainingState> first = broken.run(course_run(), 60, reports, gently);
      if (first && first->step == 60) break;  // it ended before the interruption
      ++kills;
      const std::optional<TrainingState> second = broken.run(course_run(), 60);
      ASSERT_TRUE(second);
      EXPECT_EQ(state_to_json(*second), state_to_json(*end)) << reports << gently;
      EXPECT_TRUE(broken.rows == straight.rows) << reports << gently;
      EXPECT_EQ(broken.checkpoints.at(60).weights, straight.checkpoints.at(60).weights) << reports << gently;
    }
  EXPECT_GT(kills, 150);
}

TEST(InterruptedCourse, ManyInterruptionsChangeNothingEither) {
  Simulation straight = eventful(), broken = eventful();
  const std::optional<TrainingState> end = straight.run(course_run(), 60);
  std::optional<TrainingState> state;
  for (int start = 0; !state && start < 1000; ++start) state = broken.run(course_run(), 60, 20 + start % 11);
  ASSERT_TRUE(end && state);
  EXPECT_EQ(state_to_json(*state), state_to_json(*end));
  EXPECT_TRUE(broken.rows == straight.rows);
}

TEST(InterruptedCourse, ADiskThatIsFullForAWhileChangesNothing) {
  Simulation straight = eventful(), full = eventful();
  full.has_room = [](const TrainingState& state) { return state.step < 22 || state.step > 30; };
  const auto end = straight.run(course_run(), 60), state = full.run(course_run(), 60);
  ASSERT_TRUE(end && state);
  EXPECT_EQ(state_to_json(*state), state_to_json(*end));
  EXPECT_TRUE(full.rows == straight.rows);
  EXPECT_EQ(full.checkpoints.at(60).weights, straight.checkpoints.at(60).weights);
}

TEST(InterruptedCourse, WithOrWithoutMaxSteps) {
  RunConfig first = course_run();
  first.max_steps = 30;
  Simulation straight = eventful(), halves = eventful();
  const auto end = straight.run(course_run(), 60);
  ASSERT_EQ(halves.run(first, 60)->step, 30);
  const auto state = halves.run(course_run(), 60);
  ASSERT_TRUE(end && state);
  EXPECT_EQ(state_to_json(*state), state_to_json(*end));
  EXPECT_TRUE(halves.rows == straight.rows);
}

}  // namespace
}  // namespace ld
