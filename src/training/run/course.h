// The course of a run: what is to be done next, decided from the configuration, the state that the run began
// with, and the numbers that the trainer reports. It knows neither networks nor files nor the time of day, so
// a run that continues from a checkpoint decides as one that was never stopped.
//
//   while ((next = course.next()) != Next::end) do what `next` says, then report it to the course
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "training/run/config.h"
#include "training/run/training_state.h"

namespace ld {

/// What the trainer is to do, and what it then reports.
enum class Next {
  step,      // step_begins(), then step_taken(), step_skipped() or, without a step, stop()
  validate,  // validated() or, when it was interrupted, stop()
  log,       // logged()
  save,      // saved() or not_saved()
  go_back,   // gone_back()
  end,
};

/// What no kernel of a collapsed training has.
constexpr double kNotJudged = std::numeric_limits<double>::infinity();

class RunCourse {
 public:
  /// `validates`: whether there is anything to validate on.
  RunCourse(const RunConfig& run, const WatchConfig& watch, bool validates);

  /// Begins with a new state, or continues with that of a checkpoint. Nothing is unsaved then.
  void begin(TrainingState state, int64_t total_steps);

  Next next() const;
  /// The run ends before its last step; a validation that is due stays due for whoever continues the run.
  void stop() { stopped_ = true; }
  bool time_is_up(double seconds) const;

  /// The weights are about to change. If they are the best and no checkpoint could hold them, they are lost,
  /// and what was the best before is the best again.
  void step_begins() { forget_unsaved_best(); }
  void step_taken(double loss);
  void step_skipped();
  /// So many steps in a row were skipped that the run must end with an error.
  bool has_diverged() const { return state_.skipped_in_a_row >= run_.max_skipped; }
  /// Takes the steps that were skipped in a row back, so that whoever continues the run does them again;
  /// returns how many they were.
  int64_t undo_skipped_steps();

  /// The scores of a validation: the loss, and of the kernels the mean entropy and the deviation between
  /// pixels (training/kernel_statistics.h), or kNotJudged.
  void validated(double loss, double entropy, double deviation);
  void logged();
  void saved();
  void not_saved() { save_due_ = false; }

  /// Why the training counts as collapsed; "": it does not.
  const std::string& collapse() const { return collapse_; }
  /// The last step whose checkpoint is known to be from before the collapse: the best one, or without any
  /// the last one before the losses rose.
  int64_t last_good_step() const;
  /// The trainer has loaded that checkpoint, or one from before it, or has begun anew. False when the run has
  /// gone back watch.retries times before and must end with an error.
  bool gone_back(TrainingState state);

  const TrainingState& state() const { return state_; }
  int64_t total_steps() const { return total_steps_; }
  int64_t last_step() const { return last_step_; }  // of the schedule, or before that of run.max_steps
  /// The step of the newest checkpoint, as far as the course knows of any.
  int64_t saved_step() const { return saved_.step; }
  /// The weights as they are have the best score, and no checkpoint holds them.
  bool best_is_unsaved() const { return best_unsaved_; }

 private:
  void continue_with(TrainingState state);
  void plan_what_follows();
  void forget_unsaved_best();
  void watch_kernels(double entropy, double deviation);

  RunConfig run_;
  WatchConfig watch_;
  bool validates_;
  int64_t total_steps_ = 0, last_step_ = 0;
  TrainingState state_;
  TrainingState before_skips_;  // where the steps that are being skipped in a row began
  TrainingState saved_;         // as the newest checkpoint holds it
  bool log_due_ = false, save_due_ = false, best_unsaved_ = false, stopped_ = false;
  std::string collapse_;
};

}  // namespace ld
