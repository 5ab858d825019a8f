// The course of a run, without a network: what comes after a step.
#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "tests/training/short_course.h"

namespace ld {
namespace {

RunCourse begun(const RunConfig& run, int64_t steps, bool validates = true, TrainingState state = {}) {
  RunCourse course(run, course_watch(), validates);
  course.begin(std::move(state), steps);
  return course;
}

void take_step(RunCourse& course, double loss = 1) {
  course.step_begins();
  course.step_taken(loss);
}

/// Steps that are taken, with all that follows each; validation losses fall.
void take_steps(RunCourse& course, int64_t last) {
  while (course.state().step < last || course.next() != Next::step) {
    switch (course.next()) {
      case Next::step:
        take_step(course);
        break;
      case Next::validate:
        course.validated(1 / static_cast<double>(course.state().step), kAnyKernels, kAnyDeviation);
        break;
      case Next::log:
        course.logged();
        break;
      case Next::save:
        course.saved();
        break;
      case Next::go_back:
      case Next::end:
        return;
    }
  }
}

/// Up to the end of a step whose validation is then to be done.
void reach_validation(RunCourse& course, int64_t step) {
  take_steps(course, step - 1);
  take_step(course);
}

TEST(Course, AStepIsFollowedByWhatIsDue) {
  RunCourse course = begun(course_run(), 100);
  for (int64_t step = 1; step <= 40; ++step) {
    ASSERT_EQ(course.next(), Next::step);
    take_step(course);
    if (step % 10 == 0) {
      ASSERT_EQ(course.next(), Next::validate) << step;
      EXPECT_TRUE(course.state().validation_due);
      course.validated(1 / static_cast<double>(step), kAnyKernels, kAnyDeviation);
      EXPECT_FALSE(course.state().validation_due);
    }
    if (step % 5 == 0) {
      ASSERT_EQ(course.next(), Next::log) << step;
      EXPECT_EQ(course.state().loss_count, 5);
      course.logged();
      EXPECT_EQ(course.state().loss_count, 0);
    }
    if (step % 4 == 0 || step % 10 == 0) {  // each validation here is the best
      ASSERT_EQ(course.next(), Next::save) << step;
      course.saved();
      EXPECT_EQ(course.saved_step(), step);
    }
  }
  EXPECT_EQ(course.state().best_step, 40);
}

TEST(Course, AValidationThatIsNotTheBestIsLoggedAlone) {
  RunCourse course = begun(course_run(), 100);
  take_steps(course, 20);
  reach_validation(course, 30);
  ASSERT_EQ(course.next(), Next::validate);
  course.validated(7, kAnyKernels, kAnyDeviation);
  EXPECT_EQ(course.state().best_step, 20);
  EXPECT_FALSE(course.best_is_unsaved());
  ASSERT_EQ(course.next(), Next::log);
  course.logged();
  EXPECT_EQ(course.next(), Next::step);
}

TEST(Course, WithoutFramesToValidateOnNoneIsDue) {
  RunCourse course = begun(course_run(), 10, /*validates=*/false);
  take_steps(course, 10);
  EXPECT_EQ(course.next(), Next::end);
  EXPECT_EQ(course.state().step, 10);
  EXPECT_EQ(course.state().best_step, 0);
  EXPECT_EQ(course.saved_step(), 10);
}

TEST(Course, TheLastStepIsValidatedLoggedAndSaved) {
  // The schedule's end and run.max_steps, whichever comes first; 7 is a multiple of nothing.
  for (const auto& [max_steps, steps] : std::vector<std::pair<int64_t, int64_t>>{{0, 7}, {7, 50}, {50, 7}}) {
    RunConfig run = course_run();
    run.max_steps = max_steps;
    RunCourse course = begun(run, steps);
    EXPECT_EQ(course.last_step(), 7);
    EXPECT_EQ(course.total_steps(), steps);
    take_steps(course, 6);
    take_step(course);
    ASSERT_EQ(course.next(), Next::validate);
    course.validated(1, kAnyKernels, kAnyDeviation);
    ASSERT_EQ(course.next(), Next::log);
    course.logged();
    ASSERT_EQ(course.next(), Next::save);
    course.saved();
    EXPECT_EQ(course.next(), Next::end);
  }
}

TEST(Course, ARunThatIsBeyondItsLastStepEndsAtOnce) {
  TrainingState state;
  state.step = 20;
  RunConfig run = course_run();
  run.max_steps = 10;
  EXPECT_EQ(begun(run, 100, true, state).next(), Next::end);
  run.max_steps = 20;
  EXPECT_EQ(begun(run, 100, true, state).next(), Next::end);
  run.max_steps = 21;
  EXPECT_EQ(begun(run, 100, true, state).next(), Next::step);
}

TEST(Course, TheTimeIsUpAfterMaxMinutes) {
  RunConfig run = course_run();
  EXPECT_FALSE(begun(run, 100).time_is_up(1e12)) << "0: no limit";
  run.max_minutes = 2;
  EXPECT_FALSE(begun(run, 100).time_is_up(120));
  EXPECT_TRUE(begun(run, 100).time_is_up(120.5));
}

TEST(Course, AStoppedRunEndsAndAnInterruptedValidationStaysDue) {
  RunCourse course = begun(course_run(), 100);
  take_steps(course, 9);
  EXPECT_EQ(course.saved_step(), 8);
  take_step(course);
  ASSERT_EQ(course.next(), Next::validate);
  course.stop();
  EXPECT_EQ(course.next(), Next::end) << "neither logged nor saved as if it were done";
  EXPECT_TRUE(course.state().validation_due);
  // Whoever continues validates first, and then logs.
  RunCourse later = begun(course_run(), 100, true, course.state());
  ASSERT_EQ(later.next(), Next::validate);
  later.validated(1, kAnyKernels, kAnyDeviation);
  EXPECT_EQ(later.next(), Next::log);
  // When the frames to validate on are gone meanwhile, the run goes on without.
  RunCourse without = begun(course_run(), 100, false, course.state());
  take_steps(without, 100);
  EXPECT_EQ(without.state().step, 100);
}

TEST(Course, ABestThatFoundNoRoomIsTriedAtTheEndOrForgotten) {
  RunCourse course = begun(course_run(), 10);
  reach_validation(course, 10);
  course.validated(0.5, kAnyKernels, kAnyDeviation);
  course.logged();
  ASSERT_EQ(course.next(), Next::save);
  course.not_saved();
  EXPECT_EQ(course.next(), Next::end);
  EXPECT_EQ(course.saved_step(), 8);
  EXPECT_TRUE(course.best_is_unsaved());

  TrainingState state = course.state();
  state.best_score = 0.7;
  state.best_step = 5;
  state.step = 19;
  RunCourse longer = begun(course_run(), 100, true, state);
  take_step(longer);
  longer.validated(0.5, kAnyKernels, kAnyDeviation);
  EXPECT_EQ(longer.state().best_step, 20);
  longer.logged();
  longer.not_saved();
  ASSERT_EQ(longer.next(), Next::step) << "the next checkpoint is tried in time";
  longer.step_begins();
  EXPECT_EQ(longer.state().best_step, 5) << "no checkpoint will ever hold step 20";
  EXPECT_EQ(longer.state().best_score, 0.7);
  EXPECT_FALSE(longer.best_is_unsaved());
}

TEST(Course, SkippedStepsCountAndTooManyAreTakenBack) {
  RunCourse course = begun(course_run(), 100);
  take_steps(course, 6);
  for (const int64_t step : {7, 8}) {
    course.step_begins();
    course.step_skipped();
    EXPECT_EQ(course.state().step, step);
    EXPECT_FALSE(course.has_diverged());
  }
  ASSERT_EQ(course.next(), Next::save) << "skipped steps are followed by what is due, too";
  course.saved();
  EXPECT_EQ(course.state().optimizer_steps, 6);
  take_step(course);
  EXPECT_EQ(course.state().skipped_in_a_row, 0) << "a step that is taken begins anew";
  EXPECT_EQ(course.state().skipped, 2);
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(course.has_diverged());
    course.step_begins();
    course.step_skipped();
  }
  EXPECT_TRUE(course.has_diverged());
  EXPECT_EQ(course.undo_skipped_steps(), 3);
  EXPECT_EQ(course.state().step, 9);
  EXPECT_EQ(course.state().skipped, 2);
}

TEST(Course, AJumpOfTheLossLeadsBackToTheBest) {
  RunCourse course = begun(course_run(), 100);
  take_steps(course, 31);
  ASSERT_EQ(course.state().best_step, 30);
  for (int i = 0; i < 4 && course.next() != Next::go_back; ++i) {
    take_step(course, 3);
    if (course.next() == Next::save) course.saved();
  }
  ASSERT_EQ(course.next(), Next::go_back);
  EXPECT_NE(course.collapse().find("times the usual 1"), std::string::npos) << course.collapse();
  EXPECT_EQ(course.last_good_step(), 30);
  TrainingState best;
  best.step = best.best_step = 30;
  EXPECT_TRUE(course.gone_back(best));
  EXPECT_EQ(course.next(), Next::step);
  EXPECT_EQ(course.collapse(), "");
  EXPECT_EQ(course.state().step, 30);
  EXPECT_EQ(course.saved_step(), 30);
  EXPECT_EQ(course.state().rollbacks, 1);
  EXPECT_EQ(course.state().rate_factor(), 0.5);
}

TEST(Course, GoingBackKeepsWhatTheRunTrainsOnAndEndsAfterTheRetries) {
  TrainingState begin;
  begin.dataset = "checksum";
  begin.crops_per_step = 6;
  RunCourse course(course_run(), course_watch(), true);
  course.begin(begin, 100);
  for (int64_t time = 1; time <= course_watch().retries; ++time) {
    EXPECT_TRUE(course.gone_back({}));
    EXPECT_EQ(course.state().rollbacks, time);
    EXPECT_EQ(course.state().dataset, "checksum");
    EXPECT_EQ(course.state().crops_per_step, 6);
  }
  EXPECT_FALSE(course.gone_back({}));
  EXPECT_EQ(course.state().rollbacks, course_watch().retries);
}

TEST(Course, KernelsOfOneTapAreACollapseUnlessTheyAreTheBest) {
  RunCourse course = begun(course_run(), 100);
  reach_validation(course, 10);
  course.validated(0.5, 0.01, kAnyDeviation);
  EXPECT_EQ(course.collapse(), "");
  reach_validation(course, 20);
  course.validated(0.6, 0.01, kAnyDeviation);
  EXPECT_NE(course.collapse().find("entropy is 0.01 nats"), std::string::npos) << course.collapse();
  EXPECT_EQ(course.next(), Next::go_back) << "neither logged nor saved";
  EXPECT_EQ(course.last_good_step(), 10);
}

TEST(Course, KernelsThatAreTheSameEverywhereAreNeverTheBest) {
  RunCourse course = begun(course_run(), 100);
  reach_validation(course, 10);
  course.validated(0.5, kAnyKernels, 1e-6);
  EXPECT_EQ(course.next(), Next::go_back);
  EXPECT_FALSE(course.best_is_unsaved());
  EXPECT_EQ(course.state().best_step, 0);
  EXPECT_EQ(course.last_good_step(), 0) << "the checkpoints so far may have such kernels";
}

TEST(Course, NumbersThatAreNotFiniteAreNoCollapseAndNoBest) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  RunCourse course = begun(course_run(), 100);
  reach_validation(course, 10);
  course.validated(nan, nan, nan);
  EXPECT_EQ(course.collapse(), "");
  EXPECT_EQ(course.state().best_step, 0);
  EXPECT_EQ(course.next(), Next::log);
}

TEST(Course, AnUnwatchedRunNeverGoesBack) {
  WatchConfig watch = course_watch();
  watch.enabled = false;
  RunCourse course(course_run(), watch, true);
  course.begin({}, 1000);
  take_steps(course, 200);
  for (int i = 0; i < 9; ++i) {
    take_step(course, 1e9);
    EXPECT_EQ(course.collapse(), "");
  }
  course.validated(1e9, 0, 0);
  EXPECT_EQ(course.collapse(), "");
}

}  // namespace
}  // namespace ld
