// The baseline `blur`: the best Gaussian blur of a set of frames, its width chosen for each metric in its
// favour over the whole set. No blur of one width could score better, so a network that beats it does more
// than blur.
#pragma once

#include <string>
#include <vector>

#include "evaluation/scores.h"
#include "frame/frame.h"

namespace ld {

/// 0.5 to 8 pixels in 17 steps of 2^(1/4): two neighbours differ by 19 %, about an optimum that is flat.
const std::vector<double>& blur_sigmas();

class BlurSweep {
 public:
  /// Blurs the noisy mean with every width, up to `threads` at a time, and scores the results. Both pictures
  /// [3, H, W], linear. Throws Error as the metrics do.
  void add(const std::string& frame, const Image& noisy, const Image& reference, int threads);

  /// The width whose mean over the frames so far is best; the narrower one of equals. `metric` is an index of
  /// metrics().
  double best_sigma(size_t metric) const;

  /// Method `blur`: the values of each metric are those of its own best width.
  MethodScores scores() const;

 private:
  size_t best(size_t metric) const;

  std::vector<MethodScores> sweep_ = std::vector<MethodScores>(blur_sigmas().size());  // one for each width
};

}  // namespace ld
