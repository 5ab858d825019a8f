// NaN, infinite and negative numbers, frames without content, and samples of another brightness than their
// reference.
#include <algorithm>
#include <cmath>

#include "doctor/doctor_check.h"

namespace ld {
namespace {

struct Values {
  int64_t samples = 0, masked = 0, negative = 0, clamped = 0;
  std::map<std::string, int64_t> not_finite;  // by feature
  int64_t reference_values = 0, bad_reference_values = 0;
  double sample_mean = 0, sample_error = 0;  // of the brightness, with its standard error
  double reference_mean = 0;
  bool has_reference = false;
};

Values measure(const Evidence& evidence) {
  const Frame& frame = evidence.frame;
  const size_t pixels = frame.plane_size();
  Values found;
  found.samples = static_cast<int64_t>(frame.valid.size());
  found.masked = std::count(frame.valid.begin(), frame.valid.end(), uint8_t{0});
  found.negative = evidence.faults.negative;
  found.clamped = evidence.faults.clamped;
  found.not_finite = evidence.not_finite;
  found.bad_reference_values = evidence.bad_reference_values;
  found.has_reference = evidence.reference.has_value();
  double sum = 0, variance = 0;
  for (size_t p = 0; p < pixels; ++p) {
    const double mean = evidence.mean_brightness[p];
    double squares = 0, count = 0;
    for (int s = 0; s < frame.spp; ++s) {
      if (frame.valid_plane(s)[p] == 0) continue;
      const double difference = evidence.brightness_of(s)[p] - mean;
      squares += difference * difference;
      ++count;
    }
    sum += mean;
    if (count > 1) variance += squares / (count - 1) / count;
  }
  found.sample_mean = sum / static_cast<double>(pixels);
  found.sample_error = std::sqrt(variance) / static_cast<double>(pixels);
  if (found.has_reference) {
    found.reference_values = static_cast<int64_t>(evidence.reference->pixels.size());
    double reference = 0;
    for (const float value : evidence.reference_brightness) reference += static_cast<double>(value);
    found.reference_mean = reference / static_cast<double>(pixels);
  }
  return found;
}

using All = Measurements<Values>;

// Masked or mended numbers below this share cost a data set nothing but the samples.
constexpr double kFewValues = 1e-3;

/// A count over all frames: a warning when there is any, a problem above kFewValues.
template <class Count>
void count_faults(const All& frames, Diagnosis& diagnosis, Count count, int64_t Values::*whole,
                  const char* figure, const std::string& what, const std::string& advice) {
  int64_t sum = 0, of = 0;
  std::vector<std::string> names;
  for (const auto& frame : frames) {
    of += frame.result.*whole;
    const int64_t here = count(frame.result);
    sum += here;
    if (here > 0) names.push_back(frame.name);
  }
  if (sum == 0) return;
  const bool many = static_cast<double>(sum) > kFewValues * static_cast<double>(of);
  diagnosis.add(many ? Severity::problem : Severity::warning,
                fmt::format("{} {} ({}) in {}; {}", sum, what,
                            share_text(static_cast<double>(sum), static_cast<double>(of)),
                            frames_text(names, frames.size()), advice),
                names, {{figure, sum}, {"of", of}});
}

void conclude_features(const All& frames, Diagnosis& diagnosis) {
  std::map<std::string, int64_t> features;
  for (const auto& frame : frames)
    for (const auto& [feature, count] : frame.result.not_finite) features[feature] += count;
  for (const auto& [name, total] : features) {
    const std::string feature = name;
    const auto count = [&feature](const Values& values) {
      const auto it = values.not_finite.find(feature);
      return it == values.not_finite.end() ? int64_t{0} : it->second;
    };
    count_faults(frames, diagnosis, count, &Values::samples, "not_finite",
                 fmt::format("samples hold NaN or infinity in the feature '{}'", feature),
                 feature == "radiance"
                     ? "they are masked out, which is right for samples that were never drawn (adaptive "
                       "sampling) and a bug of the renderer otherwise"
                     : fmt::format("they count as those of rays that escaped; write {}",
                                   feature == "depth" ? "65504 where the ray escaped" : "0 instead"));
  }
}

void conclude_brightness(const All& frames, Diagnosis& diagnosis) {
  // The samples' mean is an unbiased estimate of the reference's: a frame counts when they differ by a
  // quarter and by ten standard errors (heavy tails make single frames miss three or four of them).
  std::vector<std::string> names;
  std::vector<double> ratios;
  std::vector<std::string> black;
  for (const auto& frame : frames) {
    const Values& v = frame.result;
    if (!v.has_reference) continue;
    if (v.reference_mean <= 0 && v.sample_mean <= 0) black.push_back(frame.name);
    if (v.reference_mean <= 0 || v.sample_mean <= 0) {
      if (v.reference_mean != v.sample_mean) names.push_back(frame.name);
      continue;
    }
    const double ratio = v.sample_mean / v.reference_mean;
    ratios.push_back(ratio);
    if (std::abs(std::log(ratio)) > std::log(1.25) &&
        std::abs(v.sample_mean - v.reference_mean) > 10 * v.sample_error)
      names.push_back(frame.name);
  }
  if (!black.empty())
    diagnosis.add(
        Severity::warning,
        fmt::format(
            "{} are black, samples and reference; there is nothing to learn from them, leave them out",
            frames_text(black, frames.size())),
        black, {{"frames", black.size()}});
  if (names.empty()) return;
  double median = 0;
  if (!ratios.empty()) {
    std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2),
                     ratios.end());
    median = ratios[ratios.size() / 2];
  }
  const bool many = names.size() * 20 > frames.size();
  diagnosis.add(
      many ? Severity::problem : Severity::warning,
      fmt::format(
          "the samples of {} are brighter or darker than their reference by more than a quarter (samples "
          "over "
          "reference: median {:.3g}); write both linear, with the same exposure, without view transform or "
          "clamping",
          frames_text(names, frames.size()), median),
      names, {{"frames", names.size()}, {"median_ratio", median}});
}

void conclude(const All& frames, Diagnosis& diagnosis) {
  conclude_features(frames, diagnosis);
  std::vector<std::string> empty;
  for (const auto& frame : frames)
    if (frame.result.masked == frame.result.samples) empty.push_back(frame.name);
  if (!empty.empty())
    diagnosis.add(Severity::problem,
                  fmt::format("every sample is masked out in {}; there is nothing to denoise, render "
                              "them again",
                              frames_text(empty, frames.size())),
                  empty, {{"frames", empty.size()}});
  count_faults(
      frames, diagnosis, [](const Values& v) { return v.negative; }, &Values::samples, "negative",
      "radiance channels are negative",
      "they are read as 0, which brightens the mean; use a box filter (others have negative lobes) and a "
      "linear colour space that holds all colours");
  count_faults(
      frames, diagnosis, [](const Values& v) { return v.clamped; }, &Values::samples, "clamped",
      "radiance channels were clamped to 65504 when the files were written",
      "the samples are darker than their reference there; render darker or without such bright lights");
  count_faults(
      frames, diagnosis, [](const Values& v) { return v.bad_reference_values; }, &Values::reference_values,
      "bad_reference_values", "channels of reference pixels are NaN, infinite or negative",
      "networks learn the 0 that is read instead; render the references again");
  conclude_brightness(frames, diagnosis);
}

}  // namespace

std::unique_ptr<Check> make_value_check(size_t frames) {
  return FrameCheck<Values, measure, conclude>::make(frames);
}

}  // namespace ld
