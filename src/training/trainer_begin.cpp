// How a Trainer begins a run.
#include <cmath>

#include <torch/version.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/log.h"
#include "core/process/process_memory.h"
#include "core/signals.h"
#include "graph/extent.h"
#include "models/graphs/network_graph.h"
#include "ops/blas_kernels.h"
#include "training/estimate.h"
#include "training/run/run_folder.h"
#include "training/trainer.h"
#include "training/training_data.h"

namespace ld {
namespace {

constexpr double kBytesPerMegabyte = 1e6;

}  // namespace

/// On rank 0, once nothing in the configuration is wrong.
void Trainer::open_run(const std::string& command, const std::string& dataset, int64_t total_steps) {
  claim_run_folder(run_, config_);
  add_log_file(run_ / "train.log");
  RunOrigin origin;
  origin.command = command;
  origin.libtorch = TORCH_VERSION;
  origin.blas = blas_kernels();
  origin.threads = static_cast<int>(torch::get_num_threads());
  origin.processes = group_.size();
  origin.dataset = dataset;
  origin.parameters = graph::parameter_count(network_graph(config_.network));
  origin.total_steps = total_steps;
  write_origin(run_, config_, origin);
  spdlog::info("network '{}' with {} parameters; {} steps of {} crops of {}x{}; loss {}; {} thread{}{}{}",
               config_.network.name, origin.parameters, total_steps,
               config_.data.batch * config_.optimizer.accumulate, config_.data.crop, config_.data.crop,
               config_.loss, origin.threads, origin.threads == 1 ? "" : "s",
               group_.size() > 1 ? fmt::format(" in each of {} processes", group_.size()) : "",
               network_->device().is_cpu() ? "" : "; on " + network_->device().str());
  if (validation_.empty())
    spdlog::warn("the data has no validation split: `best` will be the last checkpoint");
}

/// Collective. The state of the newest whole checkpoint, or `fresh`; network and optimiser are set likewise.
TrainingState Trainer::resume(const TrainingState& fresh) {
  const std::optional<std::filesystem::path> checkpoint =
      group_.is_root() ? checkpoints_.newest_whole() : std::nullopt;
  TrainingState state = fresh;
  if (checkpoint) {
    state = read_checkpoint(*checkpoint, *network_, optimizer_);
    spdlog::info("continuing from {} at step {}", checkpoint->string(), state.step);
    if (state.crops_per_step != fresh.crops_per_step)
      fail_usage(
          "the run takes {} crops a step, but data.batch={} and optimizer.accumulate={} make {}; change them "
          "to have that product, or choose another --out",
          state.crops_per_step, config_.data.batch, config_.optimizer.accumulate, fresh.crops_per_step);
    if (state.dataset != fresh.dataset) {
      spdlog::warn("the data set has changed since that checkpoint: its manifest had the checksum {}, now {}",
                   state.dataset, fresh.dataset);
      state.dataset = fresh.dataset;
    }
    check_best(state);
  }
  return share_checkpoint(state, *network_, optimizer_, group_);
}

/// Says, before the first step, what the run will take.
void Trainer::announce() {
  Plan plan;
  plan.accumulate = config_.optimizer.accumulate;
  const int64_t first = state().step * plan.accumulate;
  const auto measure = [&](const Batch& batch) {
    return measure_batch(*network_, clip_loss_, {config_.optimizer.truncation, config_.optimizer.recompute},
                         batch, [] { return stop_requested(); });
  };
  const SampleRange& samples = training_set_.samples();
  if (!validation_.empty())
    plan.validation =
        measure_validation(optimizer_.average().network(), validation_, [] { return stop_requested(); });
  if (samples.all()) {
    plan.batch = measure(training_set_.batch(first));
  } else {  // the largest batch decides the memory, the average one the time of steps
    plan.batch = measure(training_set_.batch_with(first, samples.most));
    const auto average = static_cast<int>(std::lround(mean_sample_count(samples)));
    plan.batch.seconds = measure(training_set_.batch_with(first, average)).seconds;
  }
  if (stop_requested()) return;
  plan.steps = course_.last_step() - state().step;
  if (!validation_.empty()) plan.validations = (plan.steps - 1) / config_.run.validate_every + 1;
  plan.validation_pixels = validation_.pixels() / group_.size();
  plan.checkpoint_bytes = checkpoint_bytes(*network_, optimizer_.average());
  plan.state_megabytes = static_cast<double>(plan.checkpoint_bytes) / kBytesPerMegabyte;
  if (const int64_t available = available_bytes(); available >= 0)
    plan.available_megabytes = static_cast<double>(available + resident_bytes()) / kBytesPerMegabyte;
  plan.max_minutes = config_.run.max_minutes;
  plan.checkpoints = config_.run.keep + 2;  // the best, and the one being written
  plan.free_bytes = std::filesystem::space(run_).available;
  spdlog::info("{}", time_text(plan));
  spdlog::info("{}", disk_text(plan));
  if (!fits_in_memory(plan))
    spdlog::warn(
        "the machine has {:.0f} MB for that; take smaller validation frames or data.validation_samples, a "
        "smaller data.batch with a larger optimizer.accumulate, or another machine",
        plan.available_megabytes);
  if (!fits_on_disk(plan))
    spdlog::warn("{} has no room for that; free some, or save less with run.keep", run_.string());
}

}  // namespace ld
