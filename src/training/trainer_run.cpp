// How a Trainer begins, saves and ends a run.
#include <algorithm>
#include <cmath>
#include <thread>

#include <torch/version.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/log.h"
#include "core/signals.h"
#include "ops/blas_kernels.h"
#include "training/estimate.h"
#include "training/run/run_folder.h"
#include "training/trainer.h"
#include "training/training_data.h"

namespace ld {
namespace {

constexpr double kBytesPerMegabyte = 1e6;

/// Pauses before the last checkpoint is tried again, seconds.
constexpr double kPauses[] = {0.25, 1, 2};

}  // namespace

/// On rank 0, once nothing in the configuration is wrong.
void Trainer::open_run(const std::string& command) {
  claim_run_folder(run_, config_);
  add_log_file(run_ / "train.log");
  RunOrigin origin;
  origin.command = command;
  origin.libtorch = TORCH_VERSION;
  origin.blas = blas_kernels();
  origin.threads = static_cast<int>(torch::get_num_threads());
  origin.processes = group_.size();
  origin.dataset = state_.dataset;
  origin.parameters = parameter_count(*network_);
  origin.total_steps = total_steps_;
  write_origin(run_, config_, origin);
  spdlog::info("network '{}' with {} parameters; {} steps of {} crops of {}x{}; loss {}; {} thread{}{}",
               config_.network.name, origin.parameters, total_steps_, state_.crops_per_step,
               config_.data.crop, config_.data.crop, config_.loss, origin.threads,
               origin.threads == 1 ? "" : "s",
               group_.size() > 1 ? fmt::format(" in each of {} processes", group_.size()) : "");
  if (validation_.empty())
    spdlog::warn("the data has no validation split: `best` will be the last checkpoint");
}

void Trainer::resume() {
  const std::optional<std::filesystem::path> checkpoint =
      group_.is_root() ? checkpoints_.newest_whole() : std::nullopt;
  if (checkpoint) {
    const TrainingState fresh = state_;
    state_ = read_checkpoint(*checkpoint, *network_, optimizer_);
    spdlog::info("continuing from {} at step {}", checkpoint->string(), state_.step);
    if (state_.crops_per_step != fresh.crops_per_step)
      fail_usage(
          "the run takes {} crops a step, but data.batch={} and optimizer.accumulate={} make {}; change them "
          "to have that product, or choose another --out",
          state_.crops_per_step, config_.data.batch, config_.optimizer.accumulate, fresh.crops_per_step);
    if (state_.dataset != fresh.dataset) {
      spdlog::warn("the data set has changed since that checkpoint: its manifest had the checksum {}, now {}",
                   state_.dataset, fresh.dataset);
      state_.dataset = fresh.dataset;
    }
    check_best();
  }
  state_ = share_checkpoint(state_, *network_, optimizer_, group_);
  saved_ = before_skips_ = state_;
}

/// `best` must name what the state says; where that is lost, the next validation decides anew.
void Trainer::check_best() {
  if (validation_.empty()) {
    checkpoints_.restore_best(state_.step);
  } else if (state_.best_step > 0 && !checkpoints_.restore_best(state_.best_step)) {
    spdlog::warn("until a validation finds a better one, step {} counts as the best", state_.step);
    checkpoints_.restore_best(state_.step);
    state_.best_step = state_.step;
    state_.best_score = std::numeric_limits<double>::infinity();
  }
}

/// Says, before the first step, what the run will take.
void Trainer::announce() {
  Plan plan;
  plan.accumulate = config_.optimizer.accumulate;
  const int64_t first = state_.step * plan.accumulate;
  const auto measure = [&](const Batch& batch) {
    return measure_batch(*network_, loss_, batch, [] { return stop_requested(); });
  };
  const SampleRange samples = sample_range(config_.data);
  if (samples.all()) {
    plan.batch = measure(training_set_.batch(first));
  } else {  // the largest batch takes the memory, and validation as long a pixel; steps the average time
    plan.batch = measure(training_set_.batch_with(first, samples.most));
    const auto average = static_cast<int>(std::lround(mean_sample_count(samples)));
    plan.batch.seconds = measure(training_set_.batch_with(first, average)).seconds;
  }
  if (stop_requested()) return;
  plan.steps = last_step_ - state_.step;
  if (!validation_.empty()) plan.validations = (plan.steps - 1) / config_.run.validate_every + 1;
  plan.validation_pixels = validation_.pixels() / group_.size();
  plan.checkpoint_bytes = checkpoint_bytes(*network_, optimizer_.average());
  plan.state_megabytes = static_cast<double>(plan.checkpoint_bytes) / kBytesPerMegabyte;
  plan.max_minutes = config_.run.max_minutes;
  plan.checkpoints = config_.run.keep + 2;  // the best, and the one being written
  plan.free_bytes = std::filesystem::space(run_).available;
  spdlog::info("{}", time_text(plan));
  spdlog::info("{}", disk_text(plan));
  if (!fits_on_disk(plan))
    spdlog::warn("{} has no room for that; free some, or save less with run.keep", run_.string());
}

void Trainer::write_checkpoint(bool best) {
  nlohmann::ordered_json provenance = {{"steps", state_.step},
                                       {"dataset", state_.dataset},
                                       {"program", "ld_train " LD_VERSION},
                                       {"seed", config_.seed},
                                       {"loss", config_.loss}};
  if (best) provenance["validation_loss"] = state_.best_score;
  checkpoints_.write(
      state_.step,
      [&](const std::filesystem::path& folder) {
        write_checkpoint_files(folder, state_, *network_, optimizer_, provenance.dump());
      },
      best || validation_.empty());
}

/// False when it could not be written, which is reported: the run goes on.
bool Trainer::save(bool best) {
  if (group_.is_root()) {
    try {
      log_->flush();
      write_checkpoint(best);
    } catch (const Error& error) {
      spdlog::warn("the checkpoint of step {} is not saved: {}; the newest one is of step {}", state_.step,
                   error.what(), saved_.step);
      return false;
    }
  }
  saved_ = state_;
  best_unsaved_ = false;
  return true;
}

void Trainer::save_at_end() {
  if (save(best_unsaved_)) return;
  for (const double pause : kPauses) {
    std::this_thread::sleep_for(std::chrono::duration<double>(pause));
    if (save(best_unsaved_)) return;
  }
  fail(
      "steps {} to {} are lost: no checkpoint could be written, as reported above; make room in {} and "
      "start the same command again",
      saved_.step + 1, state_.step, run_.string());
}

/// Saves what was done when an error ends the run.
void Trainer::rescue() {
  if (state_.step <= saved_.step) return;
  try {
    write_checkpoint(best_unsaved_);
    spdlog::warn("step {} is saved before the run ends", state_.step);
  } catch (const Error& error) {
    spdlog::warn("step {} could not be saved: {}", state_.step, error.what());
  }
}

}  // namespace ld
