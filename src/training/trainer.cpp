#include "training/trainer.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "core/signals.h"
#include "metrics/metric.h"
#include "training/device.h"
#include "training/fine_tuning.h"
#include "training/measure_pace.h"
#include "training/run/run_folder.h"
#include "training/run/schedule.h"
#include "training/training_data.h"

namespace ld {
namespace {

/// The configuration with its features, the same on all processes.
TrainConfig prepare(TrainConfig config, const std::filesystem::path& run, ProcessGroup& group) {
  check_optimizer(config.optimizer);
  device_named(config.run.device);  // before anything is read
  if (group.size() > 1) {
    TrainConfig comparable = config;
    comparable.data.path.clear();  // where each machine has the data is its own business
    comparable.data.paths.clear();
    group.require_equal(fixed_configuration(comparable), "configuration");
    group.require_equal(data_checksum(config.data), "data set");
    group.require_equal(config.run.device, "run.device");  // or the weights would drift apart by rounding
  }
  if (!config.network.auto_features() && !config.network.of_init()) return config;
  if (group.is_root()) config = resolve_network(std::move(config), run);
  const std::string shared = group.broadcast(config_to_yaml(config.network), "sharing the network");
  config.network = config_from_tree<NetworkConfig>(parse_config(shared, "network of rank 0"));
  fit_to_features(config.network);
  return config;
}

}  // namespace

Trainer::Trainer(TrainConfig config, std::filesystem::path run, const TrainerOptions& options)
    : alone_(ProcessGroupOptions{}),
      group_(options.group != nullptr ? *options.group : alone_),
      start_(std::chrono::steady_clock::now()),
      config_(prepare(std::move(config), run, group_)),
      run_(std::move(run)),
      training_set_(make_training_set(config_, group_.rank(), group_.size())),
      validation_(make_validation_stores(config_), config_.run.images, validation_samples(config_.data),
                  config_.data.clip > 1),
      checkpoints_(run_, config_.run.keep),
      loss_(options.loss ? options.loss : make_loss(config_.loss)),
      clip_loss_(make_clip_loss(config_.clip_loss, loss_, network_traits(config_.network.name).in_powers)),
      kernel_probe_(options.kernel_probe ? options.kernel_probe : kernel_statistics),
      // A run that continues takes its weights from a checkpoint, and other ranks take those of rank 0.
      network_(make_initial_network(config_, group_.is_root() && !checkpoints_.begun())),
      optimizer_(network_, config_.optimizer),
      course_(config_.run, config_.watch, !validation_.empty()) {
  TrainingState fresh;
  fresh.dataset = data_checksum(config_.data);
  fresh.crops_per_step = config_.data.batch * config_.optimizer.accumulate;
  if (group_.is_root()) lock_.emplace(run_);
  const std::optional<Pace> pace =
      settle_steps(config_, {*network_, training_set_, validation_, loss_, clip_loss_, group_, run_, start_});
  const int64_t steps = schedule_steps(config_, training_set_.batches_per_epoch());
  if (steps == 0) return;  // stopped meanwhile: nothing has begun
  if (group_.is_root()) open_run(options.command, fresh.dataset, steps);
  if (group_.is_root() && pace) spdlog::info("{}", pace_text(*pace, config_.run.minutes, steps));
  TrainingState begun = resume(fresh);
  // What the network can before it learns is what every later one is compared with.
  if (validation_.has_sample_targets() && begun.step == 0) begun.validation_due = true;
  if (validation_.has_sample_targets())
    verdict_ = begun.best_step > 0 ? fmt::format("the best weights are those of step {}", begun.best_step)
                                   : "the weights of the beginning are the best so far";
  course_.begin(begun, steps);
  if (group_.is_root())
    log_.emplace(run_, state().validation_due ? state().step - 1 : state().step, config_.network.layers,
                 validation_.measures_sequences());
}

void Trainer::train() {
  if (state().step < course_.last_step() && group_.is_root()) announce();
  try {
    run_steps();
  } catch (const LostPeer&) {  // it may be rank 0, so each rank that still lives saves
    if (group_.is_root() || !checkpoints_.holds(state().step)) rescue();
    throw;
  } catch (const std::exception&) {
    if (group_.is_root()) rescue();
    throw;
  }
  if (course_.saved_step() != state().step || course_.best_is_unsaved()) save_at_end();
  group_.barrier("ending");
  lock_.reset();
}

void Trainer::run_steps() {
  std::optional<Progress> progress(std::in_place, "training", course_.last_step(), state().step);
  timer_.start();
  for (Next next = course_.next(); next != Next::end; next = course_.next()) {
    if (next == Next::step && must_stop()) {
      course_.stop();
    } else if (next == Next::step) {
      const double loss = take_step();
      if (group_.is_root()) progress->advance(1, fmt::format("loss {:.4f}", loss));
    } else if (next == Next::validate) {
      validate();
    } else if (next == Next::log) {
      log_row();
    } else if (next == Next::save) {
      save();
    } else if (next == Next::go_back) {
      go_back();
      progress.emplace("training", course_.last_step(), state().step);
    }
  }
}

/// Collective: all stop after the same step.
bool Trainer::must_stop() {
  return group_.any(stop_requested() || course_.time_is_up(seconds_since(start_)),
                    "deciding whether to stop");
}

double Trainer::rate_of(int64_t step) const {
  const double epoch = static_cast<double>(step * config_.optimizer.accumulate) /
                       static_cast<double>(training_set_.batches_per_epoch());
  return state().rate_factor() * learning_rate(config_.optimizer, step, epoch, total_steps());
}

double Trainer::take_step() {
  course_.step_begins();
  const int64_t step = state().step;
  const Optimizer::Outcome outcome =
      optimizer_.step(training_set_, step, clip_loss_, rate_of(step), state().optimizer_steps + 1, group_);
  timer_.count_step();
  if (outcome.taken) {
    course_.step_taken(outcome.loss);
    return outcome.loss;
  }
  if (group_.is_root())
    spdlog::warn("step {} skipped: loss {}, norm of the gradient {:.4g}; crops {}", step + 1, outcome.loss,
                 outcome.gradient,
                 training_set_.describe(step * config_.optimizer.accumulate, config_.optimizer.accumulate));
  course_.step_skipped();
  if (course_.has_diverged()) end_diverged();
  return outcome.loss;
}

void Trainer::end_diverged() {
  const int64_t skipped = course_.undo_skipped_steps(), step = state().step;
  fail(
      "{} steps in a row had no finite loss and gradient, from step {} on (seed {}, crops {}); '{}' repeats "
      "them from the checkpoint before; to train on, lower optimizer.learning_rate or set "
      "optimizer.clip_norm in a new run",
      skipped, step + 1, config_.seed,
      training_set_.describe(step * config_.optimizer.accumulate, config_.optimizer.accumulate),
      reproducing_command(run_, run_.string(), static_cast<int>(torch::get_num_threads())));
}

/// Collective. Of the kernels it looks at those for the first batch of the run, made beside the batches that
/// are prepared for training.
void Trainer::validate() {
  Network& network = optimizer_.average().network();
  const std::optional<ValidationResult> result =
      validation_.run(network, loss_, group_, [] { return stop_requested(); });
  if (!result) {
    course_.stop();
    return;
  }
  const torch::NoGradGuard no_graph;
  std::optional<FirstStageScore> first_stage;
  if (const Noisy noisy = noisy_beside(config_.network); noisy != Noisy::none)
    first_stage = validation_.score_first_stage(network, noisy, group_);
  row_ = result->scores;
  const Filter filter = network_traits(config_.network.name).filter;
  KernelStatistics kernels;
  if (filter != Filter::none) {
    const int samples = validation_samples(config_.data).input,
              drawn = samples > 0 ? samples : training_set_.samples().most;
    kernels = mean_over_processes(kernel_probe_(network, training_set_.batch_with(0, drawn).input),
                                  training_set_.batch_share(), group_);
    add_to_row(kernels, row_);
  }
  const double loss = validation_.has_sample_targets() ? judge(*result) : row_.at("validation_loss");
  // A network with a filter of its own may well have one kernel for all pixels.
  if (filter == Filter::own || filter == Filter::none)
    course_.validated(loss, kNotJudged, kNotJudged);
  else
    course_.validated(loss, kernels.entropy, kernels.deviation);
  if (!group_.is_root()) return;
  std::string text;
  // Beside single samples every picture is bad: what counts is what judge() says.
  if (validation_.has_sample_targets())
    text = " against noisy samples that it does not see";
  else
    for (const Metric& metric : metrics())
      text += fmt::format(", {} {:.{}f}", metric.title, row_.at(metric.name), metric.digits);
  if (const Metric& steady = sequence_measures().front(); row_.count(steady.name) > 0)
    text += fmt::format(", {} {:.{}f}", steady.title, row_.at(steady.name), steady.digits);
  spdlog::info("step {}: validation loss {:.4f}{}{}", state().step, row_.at("validation_loss"),
               course_.best_is_unsaved() ? " (best)" : "", text);
  if (first_stage)
    spdlog::info(
        "step {}: first stage: PSNR {:.2f} dB against samples that it does not see; their noise "
        "leaves the reference at {:.2f} dB",
        state().step, first_stage->psnr, first_stage->floor);
  log_->pictures(state().step, result->pictures);
  if (result->strip) log_->strip(state().step, *result->strip);
}

void Trainer::log_row() {
  if (group_.is_root()) {
    const auto batches = static_cast<double>(state().step * config_.optimizer.accumulate);
    row_["epoch"] = batches / static_cast<double>(training_set_.batches_per_epoch());
    row_["learning_rate"] = rate_of(std::max<int64_t>(state().step - 1, 0));
    row_["skipped"] = static_cast<double>(state().skipped);
    row_["rollbacks"] = static_cast<double>(state().rollbacks);
    if (state().loss_count > 0)
      row_["train_loss"] = state().loss_sum / static_cast<double>(state().loss_count);
    log_->row(state().step, row_, timer_.seconds_per_step());
    timer_.start();
  }
  row_.clear();
  course_.logged();
}

}  // namespace ld
