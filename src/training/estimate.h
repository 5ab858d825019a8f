// What a training will take, before its first step.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "dataset/input_tensors.h"
#include "losses/loss.h"
#include "models/network.h"

namespace ld {

struct BatchCost {
  double seconds = 0;            // forward and backward
  double seconds_per_pixel = 0;  // forward alone
  double megabytes = 0;          // of the process at its largest so far
};

/// Measures two passes forward and backward (one, when it takes 10 s), and keeps the faster; leaves neither
/// gradients nor anything else behind. Ends early when `stop` becomes true between passes.
BatchCost measure_batch(Network& network, const Loss& loss, const Batch& batch,
                        const std::function<bool()>& stop);

/// What is known before the first step.
struct Plan {
  BatchCost batch;
  int64_t accumulate = 1, steps = 0;  // steps that are left
  int64_t validation_pixels = 0;      // of this process, each time
  int64_t validations = 0;
  double state_megabytes = 0;  // of optimiser and averaged weights
  double max_minutes = 0;
  uint64_t checkpoint_bytes = 0;
  int64_t checkpoints = 0;  // at one time, with the one that is being written
  uint64_t free_bytes = 0;  // of the disk
};

/// Two lines for people: time and memory; disk.
std::string time_text(const Plan& plan);
std::string disk_text(const Plan& plan);

/// Whether all checkpoints find room.
bool fits_on_disk(const Plan& plan);

}  // namespace ld
