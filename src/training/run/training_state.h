// What a run must remember besides weights and optimiser, as state.json of a checkpoint holds it.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "training/run/collapse_watch.h"

namespace ld {

/// Crops, flips and the order of the data follow from the step (dataset/training_set.h).
struct TrainingState {
  int64_t step = 0;             // steps done
  int64_t optimizer_steps = 0;  // of these, steps that Adam took
  int64_t skipped = 0;          // the others: a loss or gradient was not finite
  int64_t skipped_in_a_row = 0;
  double loss_sum = 0;  // of the steps taken since the last multiple of run.log_every
  int64_t loss_count = 0;
  bool validation_due = false;  // the run was stopped while it validated this step
  double best_score = std::numeric_limits<double>::infinity();  // lowest validation loss
  int64_t best_step = 0;
  int64_t crops_per_step = 0;
  int64_t rollbacks = 0;  // times that the run went back; each halves the learning rate
  WatchState watch;
  std::string dataset;  // checksum of the manifests that the run trains on

  /// Of the schedule's learning rate, what is left after going back.
  double rate_factor() const { return std::ldexp(1.0, -static_cast<int>(rollbacks)); }
};

/// Every bit of the numbers is kept.
std::string state_to_json(const TrainingState& state);

/// `name` is what complaints call the text. Throws Error for a text that is damaged or of another version.
TrainingState state_from_json(const std::string& text, const std::string& name);

}  // namespace ld
