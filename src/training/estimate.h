// What a training will take, before its first step.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "dataset/input_tensors.h"
#include "losses/clip_loss.h"
#include "models/network.h"
#include "training/optimizer/clip_pass.h"
#include "training/validation.h"

namespace ld {

struct BatchCost {
  double seconds = 0;    // forward and backward
  double megabytes = 0;  // of the process at its largest so far
};

/// Of validation, whose frames go through the network whole: both grow with the pixels.
struct ValidationCost {
  double seconds_per_pixel = 0;
  double megabytes = 0;  // of the process while it validates the largest frame
};

/// Measures two passes forward and backward (one, when it takes 10 s), and keeps the faster; leaves neither
/// gradients nor anything else behind. Ends early when `stop` becomes true between passes.
BatchCost measure_batch(Network& network, const ClipLoss& loss, const ClipPassOptions& pass_options,
                        const Batch& batch, const std::function<bool()>& stop);

/// The same without gradients, over the middle of the largest validation frame, up to 512x512 pixels of it.
/// Memory is what the process has, what the pass takes of the pool (ops/memory_pool.h) times as many pixels
/// as the frame has more, and the pictures that are kept. A GPU's is not counted.
ValidationCost measure_validation(Network& network, const Validation& validation,
                                  const std::function<bool()>& stop);

/// What is known before the first step.
struct Plan {
  BatchCost batch;
  ValidationCost validation;
  int64_t accumulate = 1, steps = 0;  // steps that are left
  int64_t validation_pixels = 0;      // of this process, each time
  int64_t validations = 0;
  double state_megabytes = 0;      // of optimiser and averaged weights
  double available_megabytes = 0;  // with what the process has already; 0: not known
  double max_minutes = 0;
  uint64_t checkpoint_bytes = 0;
  int64_t checkpoints = 0;  // at one time, with the one that is being written
  uint64_t free_bytes = 0;  // of the disk
};

/// Two lines for people: time and memory; disk.
std::string time_text(const Plan& plan);
std::string disk_text(const Plan& plan);

/// At its largest: a training step, or the validation of the largest frame.
double memory_megabytes(const Plan& plan);
/// Whether the machine has as much memory, as far as is known.
bool fits_in_memory(const Plan& plan);

/// Whether all checkpoints find room.
bool fits_on_disk(const Plan& plan);

}  // namespace ld
