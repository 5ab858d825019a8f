// How a Trainer with run.minutes finds out how many steps there is time for.
#include <algorithm>

#include "core/file_io.h"
#include "core/log.h"
#include "core/signals.h"
#include "training/trainer.h"
#include "weights/checkpoint_files.h"

namespace ld {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int64_t kWarmUp = 2;      // steps that are not counted: threads and memory are new
constexpr int64_t kLeastSteps = 5;  // with those
constexpr int64_t kMostSteps = 32;
constexpr double kShare = 0.02;  // of the time there is, for each of three measurements

}  // namespace

/// Collective. True steps on a copy of the network, at a rate of 0; so neither weights nor moments know of
/// them. Done twice, the second time with the same steps again and again: those of a later step would be new.
Pace Trainer::measure_pace() {
  const double limit = kShare * 60 * config_.run.minutes;
  const std::shared_ptr<Network> copy = make_network(config_.network);
  copy_parameters(*network_, *copy);
  Optimizer trial(copy, config_.optimizer);
  const auto time_steps = [&](int64_t known) {
    std::vector<double> seconds;
    const auto start = Clock::now();
    for (int64_t step = 0, enough = 0; enough == 0; ++step) {
      const auto step_start = Clock::now();
      trial.step(training_set_, step % known, loss_, 0, step + 1, group_);
      if (step >= kWarmUp) seconds.push_back(seconds_since(step_start));
      const bool time_is_up = step + 1 >= kLeastSteps && seconds_since(start) > limit;
      enough = group_.any(stop_requested() || step + 1 >= kMostSteps || (group_.is_root() && time_is_up),
                          "measuring the speed");
    }
    return seconds.empty() ? std::vector<double>{0} : seconds;
  };

  Pace pace;
  const std::vector<double> first = time_steps(kMostSteps);
  pace.first_step = typical(first);
  const int64_t known = static_cast<int64_t>(first.size()) + kWarmUp;
  pace.first_steps =
      std::max<int64_t>(training_set_.batches_per_epoch() / config_.optimizer.accumulate - known, 0);
  pace.step = typical(time_steps(known));
  pace.validate_every = config_.run.validate_every;
  pace.checkpoint_every = config_.run.checkpoint_every;
  if (!validation_.empty()) pace.validation = time_validation(trial.average().network(), limit);
  if (group_.is_root()) pace.checkpoint = time_checkpoint(*copy, trial);
  return pace;
}

/// Collective. As many frames as there is time for, at least one.
double Trainer::time_validation(Network& network, double limit) {
  double seconds = 0;
  for (int pass = 0; pass < 2; ++pass) {  // the second time, the frames are in the cache
    const auto start = Clock::now();
    int64_t begun = 0;
    const bool whole = validation_
                           .run(network, loss_, group_,
                                [&] {
                                  const bool enough =
                                      stop_requested() || (begun > 0 && seconds_since(start) > limit / 2);
                                  if (!enough) ++begun;
                                  return enough;
                                })
                           .has_value();
    const auto processes = static_cast<size_t>(group_.size());
    const size_t own = (validation_.frames() + processes - 1) / processes;
    seconds = whole ? seconds_since(start)
                    : seconds_since(start) / static_cast<double>(std::max<int64_t>(begun, 1)) *
                          static_cast<double>(own);
  }
  return seconds;
}

double Trainer::time_checkpoint(const Network& network, Optimizer& optimizer) {
  const std::filesystem::path folder = run_ / ".pace.partial";
  std::filesystem::remove_all(folder);  // of a process that was killed meanwhile
  const auto start = Clock::now();
  make_folder(folder);
  write_checkpoint_files(folder, state_, network, optimizer, "");
  write_checkpoint_checksums(folder);
  flush_to_disk(folder);
  const double seconds = seconds_since(start);
  std::filesystem::remove_all(folder);
  return seconds;
}

/// Collective. The length of the schedule: of a run that continues, what its stored configuration says.
/// Returns what was measured, if anything was. After a stop meanwhile there are 0 steps.
std::optional<Pace> Trainer::settle_steps() {
  std::optional<Pace> pace;
  if (config_.steps == 0 && config_.run.minutes > 0) {
    const std::string what = "sharing the number of steps";
    const int64_t stored = group_.is_root() ? stored_steps(run_) : 0;
    config_.steps = std::stoll(group_.broadcast(std::to_string(stored), what));
    if (config_.steps == 0) {
      pace = measure_pace();
      if (group_.any(stop_requested(), what)) {
        spdlog::info("stopped before the length of the schedule was known; nothing has been written");
        return std::nullopt;
      }
      const int64_t steps = steps_within(*pace, 60 * config_.run.minutes - seconds_since(start_));
      config_.steps = std::stoll(group_.broadcast(std::to_string(steps), what));
    }
  }
  const int64_t of_epochs = config_.epochs * training_set_.batches_per_epoch() / config_.optimizer.accumulate;
  total_steps_ = config_.steps > 0 ? config_.steps : std::max<int64_t>(of_epochs, 1);
  last_step_ = config_.run.max_steps > 0 ? std::min(config_.run.max_steps, total_steps_) : total_steps_;
  return pace;
}

}  // namespace ld
