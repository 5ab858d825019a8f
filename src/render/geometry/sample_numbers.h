// The uniform numbers that one camera sample and its path consume.
#pragma once

#include <cstdint>

#include "core/random.h"
#include "render/geometry/sampling.h"

namespace ld {

/// Either independent numbers from a RandomStream, or one point of a sequence that spreads the samples of a
/// pixel evenly: Sobol' points in two dimensions, Owen-scrambled and shuffled anew for every pair of numbers
/// ("padding"; Burley, "Practical hash-based Owen scrambling", JCGT 2020). Every such point is uniform by
/// itself, so means stay unbiased; only their variance falls.
class SampleNumbers {
 public:
  explicit SampleNumbers(const RandomStream& stream) : stream_(stream) {}
  /// Point `index` of the sequence that belongs to `pixel_seed`.
  SampleNumbers(uint32_t pixel_seed, uint32_t index) : spread_(true), seed_(pixel_seed), index_(index) {}

  /// Moves on to a fixed place in the sequence, so that paths that used more or fewer numbers before meet
  /// again there.
  void seek(uint32_t pair) { pair_ = pair; }

  /// In [0, 1). One number or one pair of the sequence.
  float one() { return spread_ ? next_point().x : stream_.uniform(); }
  Vec2 two();

 private:
  Vec2 next_point();

  RandomStream stream_{0, RandomPurpose::test};
  bool spread_ = false;
  uint32_t seed_ = 0, index_ = 0, pair_ = 0;
};

}  // namespace ld
