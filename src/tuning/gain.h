// Whether a dearer choice pays: both were scored on the same frames, so that their difficulty cancels.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace ld {

struct Gain {
  double relative = 0;      // of the mean error, what the dearer choice takes away; negative: it adds
  std::optional<double> p;  // metrics/statistics.h; none for fewer frames than can tell
  bool sure = false;        // the difference is not one of chance, with kConfidence

  /// A sure gain of kLeastGain: anything else is not worth its price. A doubtful one only from kNoRisk on,
  /// which too few frames may hide.
  bool pays() const { return relative >= (sure ? kLeastGain : kNoRisk); }
  static constexpr double kLeastGain = 0.005, kNoRisk = 0.02;
};

/// Errors of the same frames in the same order. Sure by Wilcoxon's signed ranks; of two to five frames, whose
/// ranks cannot tell, by Student's interval of the mean difference; of one frame only from a twentieth on.
Gain gain_of(const std::vector<double>& dearer, const std::vector<double>& cheaper);

/// "gains 3.1 % (p = 0.002)".
std::string gain_text(const Gain& gain);

/// NaN for no errors.
double mean_error(const std::vector<double>& errors);

}  // namespace ld
