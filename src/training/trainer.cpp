#include "training/trainer.h"

#include <fmt/ranges.h>

#include <cmath>

#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "core/signals.h"
#include "metrics/metric.h"
#include "training/fine_tuning.h"
#include "training/run/run_folder.h"
#include "training/run/schedule.h"
#include "training/training_data.h"

namespace ld {
namespace {

using Clock = std::chrono::steady_clock;

/// The configuration with its features, the same on all processes.
TrainConfig prepare(TrainConfig config, const std::filesystem::path& run, ProcessGroup& group) {
  check_optimizer(config.optimizer);
  if (group.size() > 1) {
    TrainConfig comparable = config;
    comparable.data.path.clear();  // where each machine has the data is its own business
    comparable.data.paths.clear();
    group.require_equal(fixed_configuration(comparable), "configuration");
    group.require_equal(manifests_checksum(config.data), "data set");
  }
  if (!config.network.auto_features()) return config;
  if (group.is_root()) config = resolve_features(std::move(config), run);
  const std::string list = group.broadcast(
      fmt::format("features: [{}]\n", fmt::join(config.network.features, ", ")), "sharing the features");
  config.network.features =
      config_from_tree<NetworkConfig>(parse_config(list, "features of rank 0")).features;
  fit_to_features(config.network);
  return config;
}

}  // namespace

Trainer::Trainer(TrainConfig config, std::filesystem::path run, const TrainerOptions& options)
    : alone_(ProcessGroupOptions{}),
      group_(options.group != nullptr ? *options.group : alone_),
      start_(Clock::now()),
      config_(prepare(std::move(config), run, group_)),
      run_(std::move(run)),
      training_set_(make_training_set(config_, group_.rank(), group_.size())),
      validation_(make_validation_stores(config_), config_.run.images, validation_samples(config_.data)),
      checkpoints_(run_, config_.run.keep),
      loss_(options.loss ? options.loss : make_loss(config_.loss)),
      kernel_probe_(options.kernel_probe ? options.kernel_probe : kernel_statistics),
      // Of a run that continues, checkpoint and rank 0 know better.
      network_(make_initial_network(config_, group_.is_root() && !checkpoints_.begun())),
      optimizer_(network_, config_.optimizer) {
  state_.dataset = manifests_checksum(config_.data);
  state_.crops_per_step = config_.data.batch * config_.optimizer.accumulate;
  if (group_.is_root()) lock_.emplace(run_);
  const std::optional<Pace> pace = settle_steps();
  if (total_steps_ == 0) return;  // stopped meanwhile: nothing has begun
  if (group_.is_root()) open_run(options.command);
  if (group_.is_root() && pace) spdlog::info("{}", pace_text(*pace, config_.run.minutes, total_steps_));
  resume();
  if (group_.is_root())
    log_.emplace(run_, state_.validation_due ? state_.step - 1 : state_.step, config_.network.layers);
}

void Trainer::train() {
  if (state_.step < last_step_ && group_.is_root()) announce();
  try {
    run_steps();
  } catch (const LostPeer&) {  // perhaps rank 0, so whoever still lives saves
    if (group_.is_root() || !checkpoints_.holds(state_.step)) rescue();
    throw;
  } catch (const std::exception&) {
    if (group_.is_root()) rescue();
    throw;
  }
  if (saved_.step != state_.step) save_at_end();
  group_.barrier("ending");
  lock_.reset();
}

void Trainer::run_steps() {
  std::optional<Progress> progress(std::in_place, "training", last_step_, state_.step);
  timed_since_ = Clock::now();
  if (state_.validation_due) finish_step();
  while (!collapse_.empty() || (state_.step < last_step_ && !must_stop())) {
    if (!collapse_.empty()) {
      go_back();
      progress.emplace("training", last_step_, state_.step);
      if (state_.validation_due) finish_step();
      continue;
    }
    const double loss = take_step();
    if (collapse_.empty()) finish_step();
    if (group_.is_root()) progress->advance(1, fmt::format("loss {:.4f}", loss));
  }
}

/// Collective: all stop after the same step.
bool Trainer::must_stop() {
  const double minutes = config_.run.max_minutes;
  const bool time_is_up = minutes > 0 && seconds_since(start_) > 60 * minutes;
  return group_.any(stop_requested() || time_is_up, "deciding whether to stop");
}

int64_t Trainer::epoch_of(int64_t step) const {
  return step * config_.optimizer.accumulate / training_set_.batches_per_epoch();
}

double Trainer::rate_factor() const {
  return std::ldexp(1.0, -static_cast<int>(state_.rollbacks));
}

double Trainer::rate_of(int64_t step) const {
  return rate_factor() * learning_rate(config_.optimizer, step, epoch_of(step), total_steps_);
}

/// No checkpoint will ever hold it: another one may be the best.
void Trainer::forget_unsaved_best() {
  if (!best_unsaved_) return;
  state_.best_score = saved_.best_score;
  state_.best_step = saved_.best_step;
  best_unsaved_ = false;
}

double Trainer::take_step() {
  forget_unsaved_best();
  const Optimizer::Outcome outcome = optimizer_.step(training_set_, state_.step, loss_, rate_of(state_.step),
                                                     state_.optimizer_steps + 1, group_);
  ++timed_steps_;
  if (!outcome.taken) {
    skip_step(outcome);
    return outcome.loss;
  }
  ++state_.step;
  ++state_.optimizer_steps;
  state_.skipped_in_a_row = 0;
  state_.loss_sum += outcome.loss;
  ++state_.loss_count;
  watch_step(outcome.loss);
  return outcome.loss;
}

void Trainer::skip_step(const Optimizer::Outcome& outcome) {
  if (state_.skipped_in_a_row == 0) before_skips_ = state_;
  ++state_.skipped;
  ++state_.skipped_in_a_row;
  if (group_.is_root())
    spdlog::warn(
        "step {} skipped: loss {}, norm of the gradient {:.4g}; crops {}", state_.step + 1, outcome.loss,
        outcome.gradient,
        training_set_.describe(state_.step * config_.optimizer.accumulate, config_.optimizer.accumulate));
  if (state_.skipped_in_a_row >= config_.run.max_skipped) end_diverged();
  ++state_.step;
}

/// Goes back to before the first of the skipped steps, so that whoever continues the run does them again.
void Trainer::end_diverged() {
  const int64_t skipped = state_.skipped_in_a_row;
  state_ = before_skips_;
  fail(
      "{} steps in a row had no finite loss and gradient, from step {} on (seed {}, crops {}); '{}' repeats "
      "them from the checkpoint before; to train on, lower optimizer.learning_rate or set "
      "optimizer.clip_norm in a new run",
      skipped, state_.step + 1, config_.seed,
      training_set_.describe(state_.step * config_.optimizer.accumulate, config_.optimizer.accumulate),
      reproducing_command(run_, run_.string(), static_cast<int>(torch::get_num_threads())));
}

/// What comes after a step: validation, log, checkpoint, each when it is due.
void Trainer::finish_step() {
  const bool last = state_.step == last_step_;
  std::map<std::string, double> row;
  if (!validation_.empty() &&
      (state_.validation_due || last || state_.step % config_.run.validate_every == 0)) {
    state_.validation_due = true;
    if (!validate(row)) return;  // stopped; whoever continues validates first
    state_.validation_due = false;
    if (!collapse_.empty()) return;  // neither logged nor saved: it will not have been
  }
  if (last || !row.empty() || state_.step % config_.run.log_every == 0) log_row(row);
  if (state_.step % config_.run.log_every == 0) {
    state_.loss_sum = 0;
    state_.loss_count = 0;
  }
  if (best_unsaved_ || last || state_.step % config_.run.checkpoint_every == 0) save(best_unsaved_);
}

/// False when a stop was asked for meanwhile.
bool Trainer::validate(std::map<std::string, double>& row) {
  const std::optional<ValidationResult> result =
      validation_.run(optimizer_.average().network(), loss_, group_, [] { return stop_requested(); });
  if (!result) return false;
  row = result->scores;
  const double loss = row.at("validation_loss");
  best_unsaved_ = loss < state_.best_score;
  if (best_unsaved_) {
    state_.best_score = loss;
    state_.best_step = state_.step;
  }
  look_at_kernels(row);
  if (!group_.is_root()) return true;
  std::string text;
  for (const Metric& metric : metrics())
    text += fmt::format(", {} {:.{}f}", metric.title, row.at(metric.name), metric.digits);
  spdlog::info("step {}: validation loss {:.4f}{}{}", state_.step, loss, best_unsaved_ ? " (best)" : "",
               text);
  log_->pictures(state_.step, result->pictures);
  return true;
}

void Trainer::log_row(std::map<std::string, double> row) {
  if (!group_.is_root()) return;
  const auto steps = static_cast<double>(state_.step * config_.optimizer.accumulate);
  row["epoch"] = steps / static_cast<double>(training_set_.batches_per_epoch());
  row["learning_rate"] = rate_of(state_.step - 1);
  row["skipped"] = static_cast<double>(state_.skipped);
  row["rollbacks"] = static_cast<double>(state_.rollbacks);
  if (state_.loss_count > 0) row["train_loss"] = state_.loss_sum / static_cast<double>(state_.loss_count);
  log_->row(state_.step, row,
            seconds_since(timed_since_) / static_cast<double>(std::max(timed_steps_, int64_t{1})));
  timed_steps_ = 0;
  timed_since_ = Clock::now();
}

}  // namespace ld
