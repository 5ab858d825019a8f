// Methods compared in pairs: both saw the same frames, so the frames' difficulty cancels in the differences.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "evaluation/scores.h"
#include "metrics/statistics.h"

namespace ld {

/// One method against the baseline, in one metric.
struct PairedMetric {
  double mean_difference =
      0;  // method - baseline, mean over the frames; NaN when one has no score, or none has
  std::optional<Interval> interval;  // of that mean
  int better = 0, worse = 0;         // frames whose score the method improves or spoils; a NaN is worse
  int equal = 0;
  std::optional<double> p;  // signed_rank_p of the differences
};

struct PairedMethod {
  std::string name;
  std::vector<PairedMetric> metrics;  // in the order of Evaluation::metrics
};

struct Comparison {
  std::string baseline;
  size_t frame_count = 0;
  std::vector<PairedMethod> methods;  // all but the baseline, in the evaluation's order
  bool too_few_frames() const { return frame_count < size_t(kFewestFrames); }
};

/// Throws Error when the methods hold other numbers of frames.
Comparison compare_with(const Evaluation& evaluation, const MethodScores& baseline);

}  // namespace ld
