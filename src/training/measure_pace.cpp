#include "training/measure_pace.h"

#include <algorithm>

#include "core/file_io.h"
#include "core/log.h"
#include "core/signals.h"
#include "training/checkpoint.h"
#include "training/fine_tuning.h"
#include "training/run/run_folder.h"
#include "weights/checkpoint_files.h"

namespace ld {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int64_t kWarmUp = 2;      // steps that are not counted: threads and memory are new
constexpr int64_t kLeastSteps = 5;  // at least so many are done, those of the warm-up included
constexpr int64_t kMostSteps = 32;
constexpr double kShare = 0.02;  // of the time there is, for each of three measurements

/// Collective. The seconds of true steps; of a longer measurement, the first `known` steps come again and
/// again.
std::vector<double> time_steps(Optimizer& trial, const PaceSubject& subject, int64_t known, double limit) {
  std::vector<double> seconds;
  const auto start = Clock::now();
  for (int64_t step = 0, enough = 0; enough == 0; ++step) {
    const auto step_start = Clock::now();
    trial.step(subject.training_set, step % known, subject.clip_loss, 0, step + 1, subject.group);
    if (step >= kWarmUp) seconds.push_back(seconds_since(step_start));
    const bool time_is_up = step + 1 >= kLeastSteps && seconds_since(start) > limit;
    enough = subject.group.any(
        stop_requested() || step + 1 >= kMostSteps || (subject.group.is_root() && time_is_up),
        "measuring the speed");
  }
  return seconds.empty() ? std::vector<double>{0} : seconds;
}

/// Collective. As many frames as there is time for, at least one.
double time_validation(Network& network, const PaceSubject& subject, double limit) {
  double seconds = 0;
  for (int pass = 0; pass < 2; ++pass) {  // the second time, the frames are in the cache
    const auto start = Clock::now();
    int64_t begun = 0;
    const auto enough = [&] {
      if (stop_requested() || (begun > 0 && seconds_since(start) > limit / 2)) return true;
      ++begun;
      return false;
    };
    const bool whole = subject.validation.run(network, subject.loss, subject.group, enough).has_value();
    const auto processes = static_cast<size_t>(subject.group.size());
    const size_t own = (subject.validation.frames() + processes - 1) / processes;
    seconds = whole ? seconds_since(start)
                    : seconds_since(start) / static_cast<double>(std::max<int64_t>(begun, 1)) *
                          static_cast<double>(own);
  }
  return seconds;
}

double time_checkpoint(const Network& network, Optimizer& optimizer, const std::filesystem::path& run) {
  const std::filesystem::path folder = run / ".pace.partial";
  std::filesystem::remove_all(folder);  // a process that was killed while it measured leaves one
  const auto start = Clock::now();
  make_folder(folder);
  write_checkpoint_files(folder, TrainingState{}, network, optimizer, "");
  write_checkpoint_checksums(folder);
  flush_to_disk(folder);
  const double seconds = seconds_since(start);
  std::filesystem::remove_all(folder);
  return seconds;
}

/// Collective. The steps are those of a copy of the network, at a rate of 0: neither weights nor moments know
/// of them. They are done twice, the second time without a step that was not among the first ones, so that
/// all frames are in the cache by then.
Pace measure_pace(const TrainConfig& config, const PaceSubject& subject) {
  const double limit = kShare * 60 * config.run.minutes;
  const std::shared_ptr<Network> copy = copy_of(subject.network);
  Optimizer trial(copy, config.optimizer);

  Pace pace;
  const std::vector<double> first = time_steps(trial, subject, kMostSteps, limit);
  pace.first_step = typical(first);
  const int64_t known = static_cast<int64_t>(first.size()) + kWarmUp;
  pace.first_steps =
      std::max<int64_t>(subject.training_set.batches_per_epoch() / config.optimizer.accumulate - known, 0);
  pace.step = typical(time_steps(trial, subject, known, limit));
  pace.validate_every = config.run.validate_every;
  pace.checkpoint_every = config.run.checkpoint_every;
  if (!subject.validation.empty())
    pace.validation = time_validation(trial.average().network(), subject, limit);
  if (subject.group.is_root()) pace.checkpoint = time_checkpoint(*copy, trial, subject.run);
  return pace;
}

}  // namespace

std::optional<Pace> settle_steps(TrainConfig& config, const PaceSubject& subject) {
  if (config.steps > 0 || config.run.minutes == 0) return std::nullopt;
  ProcessGroup& group = subject.group;
  const std::string what = "sharing the number of steps";
  const int64_t stored = group.is_root() ? stored_steps(subject.run) : 0;
  config.steps = std::stoll(group.broadcast(std::to_string(stored), what));
  if (config.steps > 0) return std::nullopt;
  const Pace pace = measure_pace(config, subject);
  if (group.any(stop_requested(), what)) {
    spdlog::info("stopped before the length of the schedule was known; nothing has been written");
    return std::nullopt;
  }
  const int64_t steps = steps_within(pace, 60 * config.run.minutes - seconds_since(subject.start));
  config.steps = std::stoll(group.broadcast(std::to_string(steps), what));
  return pace;
}

}  // namespace ld
