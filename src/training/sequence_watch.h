// How steady a validation sequence is, and what it looks like.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "metrics/sequence_meter.h"

namespace ld {

/// A sequence for looking at, linear radiance: its first frames side by side, the noisy ones above the
/// denoised ones above the references, each made smaller by a whole factor, to at most kStripSide pixels
/// wide and high.
struct SequenceStrip {
  std::string name;  // of its first frame
  Image image;
};
constexpr int kStripFrames = 8, kStripSide = 256;

/// Mean over blocks of so many pixels a side; those at the right and below may be smaller.
Image shrunk(const Image& image, int factor);

/// Fed with the frames of one sequence after another.
class SequenceWatch {
 public:
  /// The next frame, pictures [3, H, W]. `keep`: whether it may stand in the strip.
  void add(const SurfaceGuides& guides, const Image& noisy, const Image& denoised, const Image& reference,
           bool keep);
  /// The values of sequence_measures() over all frames since the start or the last call; not finite where
  /// there is none.
  std::vector<double> finish();
  /// Of all frames that were kept; empty where none was.
  Image strip() const;

  /// The most that a pixel of the largest frame takes.
  static constexpr int64_t kBytesOfPixel = 1024;

 private:
  SequenceGround ground_;
  SequenceMeter noisy_, denoised_;
  std::vector<std::array<Image, 3>> kept_;
};

}  // namespace ld
