// Notices that a training has collapsed: the loss jumped and stays up, as it does when all kernels have
// become one tap at too high a learning rate and pass the noise through. Looks at the losses alone, and
// needs no LibTorch.
//
// The steps are cut into windows. A window whose median loss is above `loss_factor` times the usual one (the
// median over the last kRemembered calm windows) is raised; `patience` raised windows in a row are a
// collapse. A few bad steps are no collapse, nor is a slow drift, which the usual loss follows, nor is the
// descent at the start.
#pragma once

#include <cstdint>
#include <vector>

#include "training/run/config.h"

namespace ld {

/// Part of the TrainingState, so that a run that resumes decides as an uninterrupted one.
struct WatchState {
  std::vector<double> losses;   // of the window that is not full yet
  std::vector<double> medians;  // of the last calm windows, oldest first
  int64_t raised = 0;           // windows in a row
  int64_t window_begin = 0;     // step before the first of `losses`
  int64_t calm_step = 0;        // a step from before the rise: where the last calm window began
};

/// Adds the loss of `step` (from 1); true when the training has collapsed. A loss that is not finite
/// counts for nothing: such steps are skipped.
bool watch_loss(WatchState& state, const WatchConfig& config, double loss, int64_t step);

/// The median of the last calm windows; 0 while there are too few to judge by.
double usual_loss(const WatchState& state);

}  // namespace ld
