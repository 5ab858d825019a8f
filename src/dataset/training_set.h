// Batches of augmented crops, a pure function of (seed, step): whoever resumes at step n sees the crops that
// an uninterrupted run sees, whatever the number of threads that prepare them.
#pragma once

#include <torch/torch.h>

#include <memory>
#include <string>
#include <vector>

#include "dataset/epoch_plan.h"
#include "dataset/frame_store.h"
#include "dataset/network_input.h"
#include "dataset/prefetch.h"

namespace ld {

struct TrainingSetOptions {
  AugmentationOptions augmentation;
  int64_t batch = 4;
  uint64_t seed = 1;
  int workers = 2;  // threads that prepare batches ahead of their use; 0: each when it is asked for
};

/// The training split of one data set, and its weight among them (dataset/epoch_plan.h).
struct WeightedStore {
  std::unique_ptr<FrameStore> store;
  double weight = 1;
};

class TrainingSet {
 public:
  /// Throws UsageError when there are fewer frames than a batch or a frame is smaller than the crop.
  TrainingSet(std::vector<WeightedStore> sets, std::vector<std::string> features, TrainingSetOptions options);

  /// What does not fill a batch at the end of an epoch is left out of it.
  int64_t steps_per_epoch() const { return static_cast<int64_t>(plan_.crops()) / options_.batch; }

  /// The batch of a step, from 0. Throws what went wrong with it: Error for bad data.
  Batch batch(int64_t step) { return batches_.get(step); }

 private:
  Batch make(int64_t step) const;
  FrameCrop draw_crop(const FrameRef& ref, int64_t step, size_t slot) const;

  std::vector<WeightedStore> sets_;
  std::vector<std::string> features_;
  TrainingSetOptions options_;
  EpochPlan plan_;
  Prefetch<Batch> batches_;  // last: its threads use the members above
};

}  // namespace ld
