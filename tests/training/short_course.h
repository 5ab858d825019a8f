// A run of few steps, for tests of its course.
#pragma once

#include "training/run/course.h"

namespace ld {

constexpr double kAnyKernels = 2, kAnyDeviation = 0.1;  // entropy and deviation of kernels that are well

/// Rows each 5 steps, validations each 10, checkpoints each 4.
inline RunConfig course_run() {
  RunConfig run;
  run.log_every = 5;
  run.validate_every = 10;
  run.checkpoint_every = 4;
  run.max_skipped = 3;
  return run;
}

/// A jump of the loss is found within two windows of two steps.
inline WatchConfig course_watch() {
  WatchConfig watch;
  watch.window = 2;
  watch.patience = 1;
  return watch;
}

}  // namespace ld
