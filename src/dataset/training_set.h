// Batches of augmented crops of clips, a pure function of (seed, step): whoever resumes at step n sees the
// crops that an uninterrupted run sees, whatever the number of threads that prepare them. A step that takes
// its crops in several batches sees those of one large batch, in their order.
#pragma once

#include <torch/torch.h>

#include <memory>
#include <string>
#include <vector>

#include "dataset/clips.h"
#include "dataset/epoch_plan.h"
#include "dataset/frame_store.h"
#include "dataset/input_tensors.h"
#include "dataset/prefetch.h"
#include "dataset/sample_draw.h"

namespace ld {

struct TrainingSetOptions {
  AugmentationOptions augmentation;
  SampleRange samples;                // how many of a frame's samples a batch uses (dataset/sample_draw.h)
  bool sample_targets = false;        // a frame's other samples are the target, in place of its reference
  Noisy noisy = Noisy::none;          // what batches have as Batch::noisy
  std::vector<std::string> optional;  // features that crops may lack, each in a share `drop` of them
  double drop = 0;
  int clip = 1;  // frames of each crop that follow one another (dataset/clips.h)
  int64_t batch = 4;
  int64_t accumulate = 1;  // batches a step
  uint64_t seed = 1;
  int workers = 2;  // threads that prepare batches ahead of their use; 0: each when it is asked for
  int rank = 0, processes = 1;  // of several processes, each reads its own part of the same batches
};

/// The slots of a batch that one of several processes reads: all of them once, in order, as evenly as can be.
struct BatchPart {
  int64_t first = 0, count = 0;
};
BatchPart batch_part(int64_t batch, int rank, int processes);

/// The training split of one data set, and its weight among them (dataset/epoch_plan.h).
struct WeightedStore {
  std::unique_ptr<FrameStore> store;
  double weight = 1;
};

class TrainingSet {
 public:
  /// With `sample_targets`, `samples` of 0 and 0 stand for half of the fewest samples of a frame up to all
  /// but one of them, with noisy pictures of others for half of them. Throws UsageError when a set has no
  /// clip, an epoch has fewer than a batch, a frame is smaller than the crop or has fewer samples than
  /// `samples.least` and a target need, there are more processes than crops in a batch, or clips are to run
  /// backwards whose `flow` tells the way to the frame before.
  TrainingSet(std::vector<WeightedStore> sets, std::vector<std::string> features, TrainingSetOptions options);

  /// What does not fill a step at the end of an epoch is left out of it; where a step takes more crops than
  /// an epoch has, what does not fill a batch.
  int64_t batches_per_epoch() const;

  /// This process's part of a batch, counted from 0: step s takes batches s * accumulate ... Throws what went
  /// wrong with it: Error for bad data.
  Batch batch(int64_t number) { return batches_.get(number); }

  /// How many samples a batch uses; 0 and 0: all.
  const SampleRange& samples() const { return options_.samples; }

  /// That batch as it would be with `samples` samples, made on the calling thread: for estimates.
  Batch batch_with(int64_t number, int samples) const;

  /// The part's crops divided by those of the whole batch. The mean loss over the whole batch is the sum over
  /// the processes of the mean over each one's part times this.
  double batch_share() const {
    return static_cast<double>(part_.count) / static_cast<double>(options_.batch);
  }

  /// Frames and crop of every slot of the batches first ... first + count - 1, for messages.
  std::string describe(int64_t first, int64_t count) const;

 private:
  /// Where a crop stands among all those of its step: it decides the crop, whoever reads it.
  struct Slot {
    int64_t step, place;
    /// What is drawn for each frame of a clip comes from a stream of its own.
    RandomStream stream(uint64_t seed, uint32_t purpose = 0, uint32_t frame = 0) const;
  };
  Slot slot_of(int64_t number, int64_t place) const;
  std::vector<ClipRef> clips_of_batch(int64_t number) const;
  int sample_count(int64_t number) const;
  void drop_features(Batch& batch, int64_t number) const;
  /// A frame, or a noise instance of it, and which of its samples enter.
  struct FrameNoise {
    size_t frame;
    SampleList samples;
  };
  int input_samples(int held, int samples) const;
  std::vector<FrameNoise> noise_of_stay(const FrameStore& store, size_t frame, const Slot& slot,
                                        int samples) const;
  std::vector<FrameCrop> draw_clip(const ClipRef& ref, const Slot& slot, int samples) const;

  std::vector<WeightedStore> sets_;
  std::vector<std::string> features_;
  TrainingSetOptions options_;
  BatchPart part_;
  std::vector<std::vector<Clip>> clips_;  // of each set
  EpochPlan plan_;
  Prefetch<Batch> batches_;  // last: its threads use the members above
};

}  // namespace ld
