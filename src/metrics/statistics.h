// Confidence intervals of means and a test of paired differences: how far a table of a few frames can be
// trusted.
#pragma once

#include <optional>
#include <vector>

namespace ld {

constexpr double kConfidence = 0.95;

/// Where the mean of all frames that could have been drawn lies, with the probability kConfidence.
struct Interval {
  double low = 0, high = 0;
};

/// mean -+ t s / sqrt(n): Student's t of n - 1 degrees of freedom, s the sample's deviation. Takes the frames
/// as drawn independently. None for fewer than two values, or when one is not finite.
std::optional<Interval> mean_interval(const std::vector<double>& values);

/// The t that |T| exceeds with probability 1 - kConfidence; T Student's of `degrees` >= 1 degrees of freedom.
double student_t_limit(int degrees);

/// Two-sided p of Wilcoxon's signed-rank test (Wilcoxon, "Individual comparisons by ranking methods",
/// Biometrics Bulletin 1(6), 1945): how often differences with random signs would be as uneven as these.
/// Zeros are left out; equal magnitudes share the mean of their ranks. Exact up to 50 differences (all signs
/// counted, ties included), beyond that the normal approximation with the correction for ties. None when no
/// difference is left, or when one is not finite.
std::optional<double> signed_rank_p(const std::vector<double>& differences);

/// The fewest frames with which signed_rank_p can come below 1 - kConfidence: 2 / 2^6 is the first.
constexpr int kFewestFrames = 6;

}  // namespace ld
