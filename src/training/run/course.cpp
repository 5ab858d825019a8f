#include "training/run/course.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace ld {
namespace {

/// Kernels of random weights deviate by 0.005 (Xavier) to 0.1 (He), those of saturated logits by 1e-7.
constexpr double kLeastDeviation = 1e-4;

}  // namespace

RunCourse::RunCourse(const RunConfig& run, const WatchConfig& watch, bool validates)
    : run_(run), watch_(watch), validates_(validates) {}

void RunCourse::begin(TrainingState state, int64_t total_steps) {
  total_steps_ = total_steps;
  last_step_ = run_.max_steps > 0 ? std::min(run_.max_steps, total_steps) : total_steps;
  continue_with(std::move(state));
}

void RunCourse::continue_with(TrainingState state) {
  state_ = saved_ = before_skips_ = std::move(state);
  log_due_ = save_due_ = best_unsaved_ = stopped_ = false;
  collapse_.clear();
  // The run was stopped while it validated this step, so what follows a step is still to be done.
  if (state_.validation_due) plan_what_follows();
}

Next RunCourse::next() const {
  if (!collapse_.empty()) return Next::go_back;
  if (stopped_) return Next::end;
  if (state_.validation_due && validates_) return Next::validate;
  if (log_due_) return Next::log;
  if (save_due_) return Next::save;
  return state_.step < last_step_ ? Next::step : Next::end;
}

bool RunCourse::time_is_up(double seconds) const {
  return run_.max_minutes > 0 && seconds > 60 * run_.max_minutes;
}

void RunCourse::plan_what_follows() {
  const bool last = state_.step == last_step_;
  if (validates_ && (last || state_.step % run_.validate_every == 0)) state_.validation_due = true;
  log_due_ = last || state_.step % run_.log_every == 0;
  save_due_ = last || state_.step % run_.checkpoint_every == 0;
}

void RunCourse::forget_unsaved_best() {
  if (!best_unsaved_) return;
  state_.best_score = saved_.best_score;
  state_.best_step = saved_.best_step;
  best_unsaved_ = false;
}

void RunCourse::step_taken(double loss) {
  ++state_.step;
  ++state_.optimizer_steps;
  state_.skipped_in_a_row = 0;
  state_.loss_sum += loss;
  ++state_.loss_count;
  if (watch_.enabled && watch_loss(state_.watch, watch_, loss, state_.step))
    collapse_ = fmt::format(
        "for {} steps the median of the loss was above {:g} times the usual {:.4g}; it is now {:.4g}",
        watch_.window * state_.watch.raised, watch_.loss_factor, usual_loss(state_.watch), loss);
  else
    plan_what_follows();
}

void RunCourse::step_skipped() {
  if (state_.skipped_in_a_row == 0) before_skips_ = state_;
  ++state_.step;
  ++state_.skipped;
  ++state_.skipped_in_a_row;
  plan_what_follows();
}

int64_t RunCourse::undo_skipped_steps() {
  const int64_t skipped = state_.skipped_in_a_row;
  state_ = before_skips_;
  return skipped;
}

void RunCourse::validated(double loss, double entropy, double deviation) {
  state_.validation_due = false;
  log_due_ = true;
  best_unsaved_ = loss < state_.best_score;
  if (best_unsaved_) {
    state_.best_score = loss;
    state_.best_step = state_.step;
  }
  if (watch_.enabled) watch_kernels(entropy, deviation);
  if (best_unsaved_) save_due_ = true;
}

void RunCourse::watch_kernels(double entropy, double deviation) {
  // Where the best so far has such kernels, they are what the data ask for.
  if (entropy < watch_.entropy && !best_unsaved_)
    collapse_ = fmt::format("the kernels' mean entropy is {:.3g} nats, below {:g}: they have become one tap",
                            entropy, watch_.entropy);
  if (deviation < kLeastDeviation) {
    collapse_ = fmt::format(
        "all pixels have the same kernel (relative deviation {:.2g}): nothing is learnt any more", deviation);
    forget_unsaved_best();  // early in a run even this may be the best so far, but it leads nowhere
    // The losses do not show since when the kernels are the same, so without a best no checkpoint is good.
    if (state_.best_step == 0) state_.watch.calm_step = 0;
  }
}

void RunCourse::logged() {
  log_due_ = false;
  if (state_.step % run_.log_every != 0) return;
  state_.loss_sum = 0;
  state_.loss_count = 0;
}

void RunCourse::saved() {
  saved_ = state_;
  save_due_ = best_unsaved_ = false;
}

int64_t RunCourse::last_good_step() const {
  return state_.best_step > 0 ? state_.best_step : state_.watch.calm_step;
}

bool RunCourse::gone_back(TrainingState state) {
  state.dataset = state_.dataset;
  state.crops_per_step = state_.crops_per_step;
  state.rollbacks = state_.rollbacks;
  const bool may_try_again = state.rollbacks < watch_.retries;
  if (may_try_again) ++state.rollbacks;
  continue_with(std::move(state));
  return may_try_again;
}

}  // namespace ld
