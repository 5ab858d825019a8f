// What an evaluation found: one number for each method, frame and metric.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "metrics/metric.h"

namespace ld {

struct SequenceResults;

/// Of a frame, or of a sequence as a whole.
struct FrameScores {
  std::string frame;
  /// In the order of Evaluation::metrics; NaN when the picture held a NaN or an infinity.
  std::vector<double> values;
  int64_t not_finite = 0;          // values of the picture that were NaN or infinite
  std::optional<double> seconds;   // what denoising took; none for the baselines
  std::vector<bool> applies = {};  // which metrics have a meaning here; empty: all
  bool has(size_t metric) const { return applies.empty() || applies.at(metric); }
};

/// What a method costs besides its time, where that is known.
struct MethodCost {
  std::optional<int64_t> parameters;
  std::optional<double> multiply_adds;  // a pixel of the first frame
};

struct MethodScores {
  std::string name;
  std::vector<FrameScores> frames;
  std::vector<double> sigmas;  // of the blur: the width chosen for each metric, in pixels; empty for others
  MethodCost cost = {};

  /// The values of one metric of those frames that it applies to.
  std::vector<double> values(size_t metric) const;
  /// Mean of these values (for PSNR the mean of dB). NaN as soon as one is NaN, because a broken frame is not
  /// averaged away, and where there is none.
  double mean(size_t metric) const;
  /// Mean over the frames; none when a frame has none.
  std::optional<double> mean_seconds() const;
  int64_t not_finite() const;
};

struct Evaluation {
  std::string data;  // the folder, for people
  std::string split;
  std::vector<const Metric*> metrics = metrics_with({});
  bool of_sequences = false;               // its "frames" are whole sequences
  int samples = 0;                         // the first so many of each frame; 0: all
  std::vector<MethodScores> methods;       // noisy, blur, then the models as given
  std::optional<MethodScores> floor = {};  // of the references (metrics/floor.h), where all have one
  std::shared_ptr<const SequenceResults> sequences = {};  // evaluation/sequence_evaluation.h; where asked for
  std::string baseline = {};  // what the others are compared with; "": the first model, else noisy

  /// "frame" or "sequence", what scores and intervals are over, for people.
  std::string unit() const { return of_sequences ? "sequence" : "frame"; }
  /// Throws Error when there is none of that name.
  const MethodScores& method(const std::string& name) const;
  /// What `baseline` stands for. Throws UsageError when there is no such method.
  const MethodScores& baseline_method() const;
};

}  // namespace ld
