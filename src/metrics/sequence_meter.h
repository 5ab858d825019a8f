// How steady a sequence is: what its single pictures do not tell. All measures are of display values (tone
// map of eq. 7 of [MH20], clamped to [0, 1]) of denoised pictures d and references r.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "metrics/metric.h"
#include "metrics/sequence_difference.h"

namespace ld {

/// The measures, their formulas and constants; `compute` is null. In this order in SequenceMeter::scores.
const std::vector<Metric>& sequence_measures();

/// So many frames after a pixel changed it counts as one that has changed.
constexpr int kChangedFrames = 8;

/// What is the same for all methods: the references, where pixels were before, and which have changed.
class SequenceGround {
 public:
  /// The next frame, its reference [3, H, W] finite; all of one size.
  void advance(const SurfaceGuides& guides, const Image& reference);

  int width = 0, height = 0;
  size_t frames = 0;
  std::vector<double> shown, shown_before;  // display values of the reference, [3, H, W]
  Warp warp;                                // to the frame before; the first frame has none that is valid
  /// Frames since the pixel's surface came into view or the light on it changed: since the frame before does
  /// not show it there or beside, or the reference's display values differ by more than 0.1 from the warped
  /// ones, both as means over 7x7 pixels. kChangedFrames: longer ago, or since the beginning.
  std::vector<int> age;
  /// By how much the mean over the channels changed then, as means over the 7x7 pixels that changed with it;
  /// where something came into view, from what was seen at its place before. 0 at the borders that entered.
  std::vector<double> change;
  /// Pixels that stand still so far: flow of at most 1/64 pixel, and a reference within 0.1 of the first.
  std::vector<uint8_t> still;
  std::vector<double> detail;  // fine_detail of the mean over the channels

 private:
  std::vector<double> first_;
  SurfaceGuides guides_;
  std::vector<int> age_before_;
  std::vector<double> change_before_;
};

/// Of one frame, for curves. NaN where there is no number.
struct SequenceFrame {
  double error;     // mean |T(d) - T(r)|
  double warped;    // temporal error with warping, mean |e|
  double unwarped;  // square root of the mean e^2 without warping
};

struct SequenceScores {
  std::vector<double> values;  // in the order of sequence_measures(); NaN where there is none
  std::vector<bool> applies;   // whether the sequence has what the measure needs, whatever the method
};

/// One method over one sequence.
class SequenceMeter {
 public:
  /// The picture of the frame that `ground` has just been advanced to, [3, H, W]. One that holds a NaN or an
  /// infinity leaves the sequence without scores. Errors: metrics/image_pair.h.
  void add(const SequenceGround& ground, const Image& denoised);

  /// `noisy`: the meter of the noisy pictures, for the gain in steadiness.
  SequenceScores scores(const SequenceGround& ground, const SequenceMeter& noisy) const;
  const std::vector<SequenceFrame>& frames() const { return frames_; }
  /// How much of a change is still to come so many frames after it: |sum (T(r) - T(d)) c| / sum c^2 over the
  /// pixels that changed then, c their change. 1: the picture of before; 0: none of it is left. Noise and
  /// blur have no part in it, for they do not go with the change. NaN where nothing changed.
  std::array<double, kChangedFrames> left_by_age() const;

 private:
  double flicker(const SequenceGround& ground) const;

  std::vector<SequenceFrame> frames_;
  std::vector<double> before_, first_;  // display values of the frame before and of the first one
  std::vector<double> sums_, squares_;  // of display values less the first: what stands still is exactly 0
  std::array<double, kChangedFrames + 1> error_of_age_{}, lag_of_age_{}, change_of_age_{};
  std::array<int64_t, kChangedFrames + 1> pixels_of_age_{};
  double squared_change_ = 0, relative_change_ = 0, warped_change_ = 0;
  size_t warped_frames_ = 0;
  double detail_ = 0, reference_detail_ = 0;
  bool broken_ = false;
};

}  // namespace ld
