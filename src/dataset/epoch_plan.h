// Which frame each crop of an epoch comes from, when several data sets take part.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace ld {

struct FrameRef {
  size_t set = 0, frame = 0;
};

/// An epoch has as many crops as the sets have frames together. Each set gets a share of them in proportion
/// to its weight, spread evenly over the epoch. Within a set, its frames come in an order that is shuffled
/// anew after each has had its turn. A pure function of the seed and the epoch; with one set, an epoch is one
/// shuffle of its frames.
class EpochPlan {
 public:
  /// Throws UsageError when a weight is so small that an epoch has no crop of its set.
  EpochPlan(std::vector<size_t> frames, const std::vector<double>& weights, uint64_t seed);

  size_t crops() const { return crops_; }

  std::vector<FrameRef> epoch(uint32_t epoch) const;

 private:
  /// A run of frames of one set.
  std::vector<size_t> draw(size_t set, uint32_t epoch) const;

  std::vector<size_t> frames_;  // of each set
  std::vector<size_t> shares_;  // crops of each set in an epoch
  size_t crops_ = 0;
  uint64_t seed_;
};

}  // namespace ld
