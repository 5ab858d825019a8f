// Loss and metrics on whole frames that are not trained on.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dataset/frame_store.h"
#include "frame/frame.h"
#include "losses/loss.h"
#include "models/network.h"
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
  /// Up to `pictures` frames, spread evenly, are kept for looking at. Each frame enters with its first
  /// `samples` samples, or all that it has where these are fewer; 0: all.
  Validation(std::vector<std::unique_ptr<FrameStore>> stores, int64_t pictures, int samples = 0);

  /// Whether no data set has a validation split.
  bool empty() const { return frames_.empty(); }
  size_t frames() const { return frames_.size(); }
  int64_t pixels() const;  // of all frames together

  /// The frames are divided among the processes; the scores are the same whatever their number. Rank 0 has
  /// the pictures. nullopt when `stop` became true on any process between two frames.
  std::optional<ValidationResult> run(Network& network, const Loss& loss, ProcessGroup& group,
                                      const std::function<bool()>& stop) const;

 private:
  struct FrameOf {
    FrameStore* store;
    size_t index;
  };
  bool is_shown(size_t frame, const ProcessGroup& group) const;

  std::vector<std::unique_ptr<FrameStore>> stores_;
  std::vector<FrameOf> frames_;  // of all stores
  int64_t pictures_;
  int samples_;
};

}  // namespace ld
