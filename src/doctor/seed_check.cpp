// The samples of a pixel are independent of one another and of the reference. Where they are not, networks
// learn to reproduce noise, and scores flatter.
//
// Two tests, both free of assumptions about the picture:
//
// 1. The reference contains the samples. Let m be the mean of n samples with the estimated variance v, and r
// the
//    reference, a mean of N samples. Independent: E (m - r)^2 = v (1 + n/N). The samples among the N: E (m -
//    r)^2 = v (1 - n/N), and 0 when r is m. So the ratio of the two sums is at least 1, or less. A single
//    bright sample adds the same to both sums, which keeps the ratio calm under heavy tails; pixels are
//    weighted by 1 / r^2 of their surroundings.
// 2. The reference contains one of the samples more than the others (a shared seed). The samples of a pixel
// are
//    exchangeable, so T(s_i) - mean of T(s_j) is uncorrelated with any function of r, for every bounded T.
#include <algorithm>
#include <array>
#include <cmath>

#include "doctor/doctor_check.h"

namespace ld {
namespace {

constexpr size_t kTestedSamples = 64;
// Noise below this part of the brightness is the rounding of half floats.
constexpr double kRounding = 2e-3;
constexpr double kLeastPixels = 1000;
// Evenly spread samples have better means than their variance says: 12 random scenes with `sampling:
// low_discrepancy` at 8 samples come to 0.95 together. What no such sampler reaches is blamed on the
// reference: in one frame, which may be simple, less than in a data set.
constexpr double kFrameContained = 0.25, kContained = 0.5;
constexpr double kSignificant = 8;     // standard errors; 65 frames or 4480 must raise no false alarm
constexpr double kCorrelation = 0.01;  // less has no effect worth a complaint

struct Seeds {
  int tested = 0;
  std::array<int64_t, 2> equal_pairs{};  // pairs of sample parts that are alike; all pairs compared
  double pixels = 0, distance = 0, distance_squares = 0, variance = 0;  // test 1
  struct Sample {
    double sum = 0, squares = 0, own = 0, reference = 0;
  };
  std::vector<Sample> samples;  // test 2
};

std::vector<float> smooth(const std::vector<float>& plane, int width, int height, bool self) {
  std::vector<float> result(plane.size());
  const auto index = [width](int y, int x) {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0, count = 0;
      for (int j = std::max(y - 1, 0); j <= std::min(y + 1, height - 1); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, width - 1); ++i) {
          if (!self && i == x && j == y) continue;
          sum += static_cast<double>(plane[index(j, i)]);
          ++count;
        }
      result[index(y, x)] = static_cast<float>(count > 0 ? sum / count : 0);
    }
  return result;
}

/// Pairs of parts that hold the same radiance wherever one of them holds any.
void compare_parts(const Evidence& evidence, Seeds& found) {
  const Frame& frame = evidence.frame;
  const size_t step = std::max<size_t>(frame.plane_size() / 4096, 1);
  for (int a = 0; a < found.tested; ++a)
    for (int b = a + 1; b < found.tested; ++b) {
      int64_t lit = 0, equal = 0;
      for (size_t p = 0; p < frame.plane_size(); p += step) {
        const float first = evidence.brightness_of(a)[p], second = evidence.brightness_of(b)[p];
        if (first == 0.0F && second == 0.0F) continue;
        ++lit;
        equal += first == second ? 1 : 0;
      }
      ++found.equal_pairs[1];
      if (lit >= 64 && equal * 10 > lit * 9) ++found.equal_pairs[0];
    }
}

void compare_with_reference(const Evidence& evidence, Seeds& found) {
  const Frame& frame = evidence.frame;
  const std::vector<float>& reference = evidence.reference_brightness;
  const std::vector<float> around = smooth(reference, frame.width, frame.height, true),
                           others = smooth(reference, frame.width, frame.height, false);
  double mean_reference = 0;
  for (const float value : reference) mean_reference += static_cast<double>(value);
  mean_reference /= static_cast<double>(reference.size());
  const double floor = kDarkShare * mean_reference;
  if (!(floor > 0)) return;
  found.samples.resize(static_cast<size_t>(found.tested));
  std::vector<double> bounded(static_cast<size_t>(found.tested));
  for (size_t p = 0; p < frame.plane_size(); ++p) {
    int count = 0;
    double squares = 0;
    const double mean = evidence.mean_brightness[p];
    for (int s = 0; s < frame.spp; ++s) {
      if (frame.valid_plane(s)[p] == 0) continue;
      const double difference = evidence.brightness_of(s)[p] - mean;
      squares += difference * difference;
      ++count;
    }
    if (count < 2) continue;
    const double variance = squares / (count - 1) / count, scale = static_cast<double>(around[p]) + floor;
    const double rounding = kRounding * (scale + mean);
    if (variance > rounding * rounding) {
      const double difference = mean - static_cast<double>(reference[p]);
      const double excess = (difference * difference - variance) / (scale * scale);
      ++found.pixels;
      found.distance += excess;
      found.distance_squares += excess * excess;
      found.variance += variance / (scale * scale);
    }
    if (count < frame.spp) continue;
    double bounded_mean = 0;
    for (size_t s = 0; s < bounded.size(); ++s) {
      const double value = evidence.brightness_of(static_cast<int>(s))[p];
      bounded[s] = value / (value + scale);
      bounded_mean += bounded[s] / static_cast<double>(bounded.size());
    }
    const double detail =
        std::clamp((static_cast<double>(reference[p]) - static_cast<double>(others[p])) / scale, -1.0, 1.0);
    for (size_t s = 0; s < bounded.size(); ++s) {
      const double own = bounded[s] - bounded_mean;
      Seeds::Sample& sample = found.samples[s];
      sample.sum += own * detail;
      sample.squares += own * detail * own * detail;
      sample.own += own * own;
      sample.reference += detail * detail;
    }
  }
}

Seeds measure(const Evidence& evidence) {
  Seeds found;
  found.tested = std::min(evidence.frame.spp, static_cast<int>(kTestedSamples));
  if (found.tested < 2) return found;
  compare_parts(evidence, found);
  if (evidence.reference) compare_with_reference(evidence, found);
  return found;
}

using All = Measurements<Seeds>;

void conclude_parts(const All& frames, Diagnosis& diagnosis) {
  std::vector<std::string> names;
  int64_t equal = 0, pairs = 0;
  for (const auto& frame : frames) {
    equal += frame.result.equal_pairs[0];
    pairs += frame.result.equal_pairs[1];
    if (frame.result.equal_pairs[0] > 0) names.push_back(frame.name);
  }
  if (names.empty()) return;
  diagnosis.add(
      Severity::problem,
      fmt::format(
          "sample parts repeat each other in {} ({} of {} pairs are the same picture); render each with "
          "another seed",
          frames_text(names, frames.size()), equal, pairs),
      names, {{"equal_pairs", equal}, {"pairs", pairs}});
}

void conclude_containment(const All& frames, Diagnosis& diagnosis) {
  Seeds sum;
  std::vector<std::string> names;
  for (const auto& frame : frames) {
    const Seeds& s = frame.result;
    sum.pixels += s.pixels;
    sum.distance += s.distance;
    sum.distance_squares += s.distance_squares;
    sum.variance += s.variance;
    if (s.pixels >= kLeastPixels / 4 && 1 + s.distance / s.variance < kFrameContained)
      names.push_back(frame.name);
  }
  if (sum.pixels < kLeastPixels) return;
  const double ratio = 1 + sum.distance / sum.variance,
               errors = -sum.distance / std::sqrt(sum.distance_squares);
  diagnosis.facts["reference_distance"] = {{"over_sample_variance", ratio},
                                           {"standard_errors_below_1", errors}};
  const bool everywhere = ratio < kContained && errors > kSignificant;
  if (names.empty() && !everywhere) return;
  diagnosis.add(
      Severity::problem,
      fmt::format(
          "the references of {} hold the samples themselves: the squared distance of the samples' mean to "
          "them "
          "is {:.2g} of what their variance predicts over all frames (independent: 1 or more); render "
          "references with other random numbers",
          names.empty() ? "the data set" : frames_text(names, frames.size()), ratio),
      names, diagnosis.facts["reference_distance"]);
}

void conclude_samples(const All& frames, Diagnosis& diagnosis) {
  std::vector<Seeds::Sample> sums;
  for (const auto& frame : frames) {
    if (sums.size() < frame.result.samples.size()) sums.resize(frame.result.samples.size());
    for (size_t s = 0; s < frame.result.samples.size(); ++s) {
      const Seeds::Sample& sample = frame.result.samples[s];
      sums[s].sum += sample.sum;
      sums[s].squares += sample.squares;
      sums[s].own += sample.own;
      sums[s].reference += sample.reference;
    }
  }
  size_t worst = 0;
  double largest = 0, correlation = 0;
  for (size_t s = 0; s < sums.size(); ++s) {
    const double errors = sums[s].squares > 0 ? sums[s].sum / std::sqrt(sums[s].squares) : 0;
    if (errors <= largest) continue;
    worst = s;
    largest = errors;
    correlation = sums[s].sum / std::sqrt(sums[s].own * sums[s].reference);
  }
  if (largest < kSignificant || correlation < kCorrelation) return;
  diagnosis.add(
      Severity::problem,
      fmt::format("sample s{:03} is in the references: its difference to the other samples correlates with "
                  "their detail "
                  "({:.3f}, {:.0f} standard errors from 0); render references with other random numbers",
                  worst, correlation, largest),
      {}, {{"sample", worst}, {"correlation", correlation}, {"standard_errors", largest}});
}

void conclude(const All& frames, Diagnosis& diagnosis) {
  conclude_parts(frames, diagnosis);
  conclude_containment(frames, diagnosis);
  conclude_samples(frames, diagnosis);
}

}  // namespace

std::unique_ptr<Check> make_seed_check(size_t frames) {
  return FrameCheck<Seeds, measure, conclude>::make(frames);
}

}  // namespace ld
