// Loss and metrics on whole frames that are not trained on, sequence by sequence.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "dataset/frame_store.h"
#include "dataset/input_tensors.h"
#include "frame/frame.h"
#include "losses/loss.h"
#include "models/network.h"
#include "sequence/sequence_state.h"
#include "training/distributed/process_group.h"

namespace ld {

/// A validation frame for looking at, linear radiance.
struct ValidationPicture {
  std::string name;
  Image noisy, denoised, reference;
};

struct ValidationResult {
  std::map<std::string, double> scores;  // means over the frames: "validation_loss" and each metric
  std::vector<ValidationPicture> pictures;
};

class Validation {
 public:
  /// A frame of one [1, S, ...], denoised [1, 3, H, W]. The state has been told of the frame.
  using Denoise = std::function<torch::Tensor(NetworkInput input, SequenceState& state)>;

  /// Up to `pictures` frames, spread evenly, are kept for looking at. Each frame enters with its first
  /// `samples` samples, or all that it has where these are fewer; 0: all.
  Validation(std::vector<std::unique_ptr<FrameStore>> stores, int64_t pictures, int samples = 0);

  /// Whether no data set has a validation split.
  bool empty() const { return frames_.empty(); }
  size_t frames() const { return frames_.size(); }
  int64_t pixels() const;  // of all frames together

  /// The frame that takes the most memory, which is in proportion to pixels times samples.
  int64_t pixels_of_largest() const;
  /// Its middle, up to `side` pixels wide and high. Throws Error as run() does.
  Batch middle_of_largest(const std::vector<std::string>& features, int side) const;
  /// Of the pictures of the largest frame that exist at a time, those that are kept among them.
  int64_t picture_bytes() const;

  /// The sequences are divided among the processes; the scores are the same whatever their number. Rank 0 has
  /// the pictures. nullopt when `stop` became true on any process between two frames.
  std::optional<ValidationResult> run(Network& network, const Loss& loss, ProcessGroup& group,
                                      const std::function<bool()>& stop) const;

  /// The same for whatever denoises frames of these features in the order of their sequence.
  std::optional<ValidationResult> run(const Denoise& denoise, const std::vector<std::string>& features,
                                      const Loss& loss, ProcessGroup& group,
                                      const std::function<bool()>& stop) const;

 private:
  struct FrameOf {
    FrameStore* store;
    size_t index;
    SequencePlace place;
  };
  int samples_of(const FrameOf& frame) const;
  const FrameOf& largest() const;
  /// The frames of a process, by their numbers in the order in which it denoises them.
  std::vector<size_t> frames_of(const ProcessGroup& group) const;
  std::set<size_t> shown(const ProcessGroup& group) const;

  std::vector<std::unique_ptr<FrameStore>> stores_;
  std::vector<FrameOf> frames_;                 // of all stores
  std::vector<std::vector<size_t>> sequences_;  // of frames_ (sequence/sequence_runs.h); stills are their own
  int64_t pictures_;
  int samples_;
};

}  // namespace ld
