// The learning rate of each step.
#pragma once

#include <cstdint>

#include "training/run/config.h"

namespace ld {

/// The rate for `step` (from 0) of `total_steps`, which lies `epoch` epochs behind the beginning:
///  - constant: learning_rate;
///  - step: learning_rate * step_factor^n in epoch n * step_epochs and after;
///  - cosine: from learning_rate to 0 along half a cosine (Loshchilov and Hutter 2017, without restarts);
///  - one_cycle (Smith and Topin 2018, with PyTorch's defaults): over the share `one_cycle.rise` of the steps
///    from learning_rate * one_cycle.start up to learning_rate, then down to learning_rate * one_cycle.end,
///    each along half a cosine.
///  - inverse_root (Chaitanya et al. 2017, section 5.3): over `ramp_epochs` epochs r from learning_rate *
///    ramp_start geometrically up to learning_rate, then learning_rate * sqrt(r / epoch).
/// During the first `warmup_steps` that is multiplied by (step + 1) / warmup_steps.
double learning_rate(const OptimizerConfig& config, int64_t step, double epoch, int64_t total_steps);

/// The length of the schedule: `steps`, or without those what `epochs` make with so many batches in each. 0
/// where run.minutes decides and has not been turned into steps.
int64_t schedule_steps(const TrainConfig& config, int64_t batches_per_epoch);

/// Throws UsageError for settings that contradict each other.
void check_optimizer(const OptimizerConfig& config);

}  // namespace ld
