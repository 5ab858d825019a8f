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
#include "dataset/sample_draw.h"
#include "frame/frame.h"
#include "losses/loss.h"
#include "models/network.h"
#include "sequence/sequence_state.h"
#include "training/distributed/process_group.h"
#include "training/sequence_watch.h"

namespace ld {

/// A validation frame for looking at, linear radiance.
struct ValidationPicture {
  std::string name;
  Image noisy, denoised, reference;
};

struct ValidationResult {
  /// Means over the frames: "validation_loss" and each metric; of Validation::measures_sequences() also each
  /// of sequence_measures(), means over the sequences that have it, absent where none has.
  std::map<std::string, double> scores;
  std::vector<ValidationPicture> pictures;
  std::optional<SequenceStrip> strip;  // of a sequence that is measured
  // With targets from samples (training/held_out.h), on all processes:
  std::vector<double> block_errors;  // of all frames
  double correlation = 0;            // of samples, mean over the frames
};

/// How many samples of a frame enter, and what the picture is compared with.
struct ValidationSamples {
  int input = 0;  // the first so many of each frame, or all where it has fewer; 0: all
  /// The mean of samples that do not enter takes the place of the reference: in turns, each quarter of them
  /// (each one, of fewer than four), so that every sample is a target once. Scores are the means over the
  /// turns.
  bool targets = false;
};

/// How near the first stage of a network comes to noisy pictures that it does not see, and how near the
/// reference does: no picture without their noise comes much nearer. PSNR of tone-mapped values in dB, over
/// all frames.
struct FirstStageScore {
  double psnr = 0, floor = 0;
};

class Validation {
 public:
  /// A frame of one [1, S, ...] and its reference, as Network::compare() has them. The state has been told of
  /// the frame.
  using Denoise =
      std::function<Compared(NetworkInput input, const torch::Tensor& reference, SequenceState& state)>;

  /// Up to `pictures` frames, spread evenly, are kept for looking at. `sequences`: how steady sequences are
  /// is measured, too, as `ld_eval --sequences` does, where there are any and targets are references. What
  /// moved where is read from the frames' files each time, because the cache holds the network's features
  /// alone.
  Validation(std::vector<std::unique_ptr<FrameStore>> stores, int64_t pictures,
             ValidationSamples samples = {}, bool sequences = false);

  /// Whether no data set has a validation split.
  bool empty() const { return frames_.empty(); }
  size_t frames() const { return frames_.size(); }
  bool has_sample_targets() const { return samples_.targets; }
  bool measures_sequences() const { return measures_sequences_; }
  int64_t pixels() const;  // of all frames together

  /// The frame that takes the most memory, which is in proportion to pixels times samples.
  int64_t pixels_of_largest() const;
  /// Its middle, up to `side` pixels wide and high. Throws Error as run() does.
  Batch middle_of_largest(const std::vector<std::string>& features, int side) const;
  /// Of the pictures of the largest frame that exist at a time, those that are kept among them, and of what
  /// measures sequences.
  int64_t picture_bytes() const;

  /// The sequences are divided among the processes; the scores are the same whatever their number. Rank 0 has
  /// the pictures. nullopt when `stop` became true on any process between two frames.
  std::optional<ValidationResult> run(Network& network, const Loss& loss, ProcessGroup& group,
                                      const std::function<bool()>& stop) const;

  /// The same for whatever denoises frames of these features in the order of their sequence.
  std::optional<ValidationResult> run(const Denoise& denoise, const std::vector<std::string>& features,
                                      const Loss& loss, ProcessGroup& group,
                                      const std::function<bool()>& stop) const;

  /// Of a network in two stages, with what stands beside its crops (dataset/sample_draw.h). Collective;
  /// nullopt where no frame has other samples than those it reads.
  std::optional<FirstStageScore> score_first_stage(Network& network, Noisy noisy, ProcessGroup& group) const;

 private:
  struct FrameOf {
    FrameStore* store;
    size_t index;
    SequencePlace place;
    int64_t first_block = 0;  // of its errors among those of all frames
  };
  int samples_of(const FrameOf& frame) const;
  int turns_of(const FrameOf& frame) const;
  Batch read(const FrameOf& frame, const std::vector<std::string>& features, const Augmentation& part,
             int turn = 0, Noisy noisy = Noisy::none) const;
  const FrameOf& largest() const;
  /// The frames of a process, by their numbers in the order in which it denoises them.
  std::vector<size_t> frames_of(const ProcessGroup& group) const;
  std::set<size_t> shown(const ProcessGroup& group) const;
  /// The sequence of rank 0 that is kept for looking at; nullopt: none.
  std::optional<int64_t> sequence_shown(const ProcessGroup& group) const;
  bool is_sequence(int64_t sequence) const { return sequences_[static_cast<size_t>(sequence)].size() > 1; }
  SurfaceGuides guides_of(const FrameOf& frame) const;

  std::vector<std::unique_ptr<FrameStore>> stores_;
  std::vector<FrameOf> frames_;                 // of all stores
  std::vector<std::vector<size_t>> sequences_;  // of frames_ (sequence/sequence_runs.h); stills are their own
  int64_t pictures_, blocks_ = 0;
  ValidationSamples samples_;
  bool measures_sequences_ = false;
};

}  // namespace ld
