// The learning rate of each step.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "training/config.h"

namespace ld {

/// The rate for `step` (from 0) of `total_steps`.
inline double learning_rate(const OptimizerConfig& config, int64_t step, int64_t steps_per_epoch,
                            int64_t total_steps) {
  double rate = config.learning_rate;
  if (config.schedule == "halve") {
    const int64_t halvings = step / steps_per_epoch / config.halve_every;
    rate *= std::pow(0.5, static_cast<double>(halvings));
  } else if (config.schedule == "cosine") {
    const double progress = static_cast<double>(step) / static_cast<double>(total_steps);
    rate *= 0.5 * (1 + std::cos(3.14159265358979 * std::min(progress, 1.0)));
  }
  if (step < config.warmup_steps)
    rate *= static_cast<double>(step + 1) / static_cast<double>(config.warmup_steps);
  return rate;
}

}  // namespace ld
