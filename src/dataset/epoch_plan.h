// Which clip each crop of an epoch is of, when several data sets take part.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace ld {

struct ClipRef {
  size_t set = 0, clip = 0;
};

/// Each set gets a share of an epoch's crops in proportion to its weight, spread evenly over the epoch.
/// Within a set, its clips come in an order that is shuffled anew after each has had its turn. A pure
/// function of the seed and the epoch; with one set and as many crops as clips, an epoch is one shuffle of
/// its clips.
class EpochPlan {
 public:
  /// Throws UsageError when a weight is so small that an epoch has no crop of its set.
  EpochPlan(std::vector<size_t> clips, size_t crops, const std::vector<double>& weights, uint64_t seed);

  size_t crops() const { return crops_; }

  std::vector<ClipRef> epoch(uint32_t epoch) const;

 private:
  /// The clips of one set.
  std::vector<size_t> draw(size_t set, uint32_t epoch) const;

  std::vector<size_t> clips_;   // of each set
  std::vector<size_t> shares_;  // crops of each set in an epoch
  size_t crops_;                // in an epoch
  uint64_t seed_;
};

}  // namespace ld
