// How a run with run.minutes finds out how many steps there is time for: by doing some, and what comes
// between them.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>

#include "dataset/training_set.h"
#include "losses/clip_loss.h"
#include "models/network.h"
#include "training/distributed/process_group.h"
#include "training/run/config.h"
#include "training/run/pace.h"
#include "training/validation.h"

namespace ld {

/// The run whose pace is measured; nothing of it changes.
struct PaceSubject {
  const Network& network;
  TrainingSet& training_set;
  const Validation& validation;
  const Loss& loss;
  const ClipLoss& clip_loss;
  ProcessGroup& group;
  const std::filesystem::path& run;
  std::chrono::steady_clock::time_point start;  // of the program: what it took so far is gone
};

/// Collective. Where run.minutes decides, sets config.steps: of a run that continues, to what its stored
/// configuration says, else to as many as there is time for, and returns what was measured for that. After a
/// stop meanwhile there are 0 steps.
std::optional<Pace> settle_steps(TrainConfig& config, const PaceSubject& subject);

}  // namespace ld
