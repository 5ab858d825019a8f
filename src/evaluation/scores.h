// What an evaluation found: one number for each method, frame and metric.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ld {

struct FrameScores {
  std::string frame;
  std::vector<double> values;     // in the order of metrics(); NaN when the picture held a NaN or an infinity
  int64_t not_finite = 0;         // values of the picture that were NaN or infinite
  std::optional<double> seconds;  // what denoising took; none for the baselines
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

  /// The frames' values of one metric.
  std::vector<double> values(size_t metric) const;
  /// Mean of the frames' values of one metric (for PSNR the mean of dB). NaN as soon as one frame is NaN: a
  /// broken frame is not averaged away.
  double mean(size_t metric) const;
  /// Mean over the frames; none when a frame has none.
  std::optional<double> mean_seconds() const;
  int64_t not_finite() const;
};

struct Evaluation {
  std::string data;  // the folder, for people
  std::string split;
  int samples = 0;                         // the first so many of each frame; 0: all
  std::vector<MethodScores> methods;       // noisy, blur, then the models as given
  std::optional<MethodScores> floor = {};  // of the references (metrics/floor.h), where all have one
  std::string baseline = {};  // what the others are compared with; "": the first model, else noisy

  /// Throws Error when there is none of that name.
  const MethodScores& method(const std::string& name) const;
  /// What `baseline` stands for. Throws UsageError when there is no such method.
  const MethodScores& baseline_method() const;
};

}  // namespace ld
