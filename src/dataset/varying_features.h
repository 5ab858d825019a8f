// Which features of a data set say anything: the answer to `network.features: auto` in a config, and a part
// of what ld_inspect reports.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "frame/frame.h"

namespace ld {

/// What the frames seen so far say of one feature.
struct FeatureRange {
  static constexpr float kNone = std::numeric_limits<float>::infinity();
  std::string name;
  int64_t frames = 0;  // frames that hold it
  // Of each of its channels over all valid samples, in the units of the files; low > high where there are
  // none.
  float low[3] = {kNone, kNone, kNone}, high[3] = {-kNone, -kNone, -kNone};
  bool varies = false;  // some channel ranges over more than rounding does
};

/// Whether values of this feature from `low` to `high` differ by more than rounding does.
bool wider_than_rounding(const std::string& feature, float low, float high);

/// Collects ranges frame by frame. The same frames give the same answers in any order.
class FeatureVariation {
 public:
  FeatureVariation();

  /// `frame.features` are those that count as held.
  void add(const Frame& frame);

  int64_t frames() const { return frames_; }

  /// In the order of the schema. Depths of rays that escaped count as depths.
  const std::vector<FeatureRange>& ranges() const { return ranges_; }

  /// Radiance, and every feature that all frames hold and that varies; but the place on the lens only where a
  /// circle of confusion is not 0, and the time only where something moves, where frames say so: random
  /// numbers that the picture does not depend on are noise to a network.
  std::vector<std::string> used() const;

  /// Why a feature is not among used(), for people; "" when it is.
  std::string reason(const std::string& feature) const;

  /// Whether no further frame could add to used().
  bool settled() const;

 private:
  std::vector<FeatureRange> ranges_;
  int64_t frames_ = 0;
};

/// used() over the frames of one split of all the data sets; reads frames on `threads` threads until it is
/// settled, all of them where some feature never varies. Throws Error: no such frames, or damaged ones.
std::vector<std::string> varying_features(const std::vector<std::filesystem::path>& folders,
                                          const std::string& split, int threads);

}  // namespace ld
