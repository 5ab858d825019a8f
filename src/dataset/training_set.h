// Batches of augmented crops, a pure function of (seed, step): whoever resumes at step n sees the crops that
// an uninterrupted run sees.
#pragma once

#include <torch/torch.h>

#include <future>
#include <string>
#include <vector>

#include "dataset/frame_store.h"
#include "dataset/network_input.h"

namespace ld {

struct Batch {
  NetworkInput input;
  torch::Tensor reference;  // [B, 3, H, W] linear
};

struct TrainingSetOptions {
  int64_t crop = 128, batch = 4;
  bool flips = true, rotations = true;
  uint64_t seed = 1;
};

class TrainingSet {
 public:
  /// Throws UsageError when there are fewer frames than a batch or a frame is smaller than the crop.
  TrainingSet(FrameStore store, std::vector<std::string> features, TrainingSetOptions options);
  ~TrainingSet();

  int64_t steps_per_epoch() const { return static_cast<int64_t>(store_.size()) / options_.batch; }

  /// The batch of a step, from 0; the frames are shuffled anew each epoch. The next step's batch is prepared
  /// in the background meanwhile.
  Batch batch(int64_t step);

 private:
  Batch make(int64_t step);

  FrameStore store_;
  std::vector<std::string> features_;
  TrainingSetOptions options_;
  std::future<Batch> next_;
  int64_t next_step_ = -1;
};

}  // namespace ld
