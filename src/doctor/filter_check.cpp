// A sample counts in one pixel only. With a wider pixel filter a path is splatted into its neighbours as
// well, so that sample i of a pixel and sample i of the next one rise and fall together; independent ones do
// not.
#include <algorithm>
#include <cmath>

#include "doctor/doctor_check.h"

namespace ld {
namespace {

// A tent over 3 x 3 pixels gives 0.67, a Gaussian cut at 1.5 pixels more; independent samples 0 +- 0.001.
constexpr double kCorrelated = 0.05;
constexpr double kSignificant = 8;  // standard errors

struct Neighbours {
  double pairs = 0, product = 0, product_squares = 0, own = 0, next = 0;
};

/// [spp][pixel]: T(s_i) - mean of T(s_j) with T(s) = s / (s + the pixel's mean), bounded so that single
/// bright samples do not decide; NaN where samples are missing.
std::vector<float> residuals(const Evidence& evidence) {
  const Frame& frame = evidence.frame;
  const size_t pixels = frame.plane_size();
  double floor = 0;
  for (const float value : evidence.mean_brightness) floor += static_cast<double>(value);
  floor *= kDarkShare / static_cast<double>(pixels);
  std::vector<float> result(evidence.brightness.size());
  for (size_t p = 0; p < pixels; ++p) {
    const double scale = static_cast<double>(evidence.mean_brightness[p]) + floor + 1e-30;
    double mean = 0;
    bool complete = true;
    for (int s = 0; s < frame.spp; ++s) {
      const double value = evidence.brightness_of(s)[p];
      mean += value / (value + scale) / frame.spp;
      complete = complete && frame.valid_plane(s)[p] != 0;
    }
    for (int s = 0; s < frame.spp; ++s) {
      const double value = evidence.brightness_of(s)[p];
      result[static_cast<size_t>(s) * pixels + p] =
          complete ? static_cast<float>(value / (value + scale) - mean) : std::nanf("");
    }
  }
  return result;
}

void add_pairs(const std::vector<float>& values, size_t from, size_t step, Neighbours& sums) {
  const double own = values[from], next = values[from + step];
  if (std::isnan(own) || std::isnan(next)) return;
  ++sums.pairs;
  sums.product += own * next;
  sums.product_squares += own * next * own * next;
  sums.own += own * own;
  sums.next += next * next;
}

Neighbours measure(const Evidence& evidence) {
  const Frame& frame = evidence.frame;
  Neighbours sums;
  if (frame.spp < 2) return sums;
  const std::vector<float> values = residuals(evidence);
  const auto width = static_cast<size_t>(frame.width), height = static_cast<size_t>(frame.height);
  for (size_t s = 0; s < static_cast<size_t>(frame.spp); ++s)
    for (size_t y = 0; y < height; ++y)
      for (size_t x = 0; x < width; ++x) {
        const size_t at = s * width * height + y * width + x;
        if (x + 1 < width) add_pairs(values, at, 1, sums);
        if (y + 1 < height) add_pairs(values, at, width, sums);
      }
  return sums;
}

double correlation(const Neighbours& sums) {
  return sums.own > 0 && sums.next > 0 ? sums.product / std::sqrt(sums.own * sums.next) : 0;
}
double standard_errors(const Neighbours& sums) {
  return sums.product_squares > 0 ? sums.product / std::sqrt(sums.product_squares) : 0;
}

void conclude(const Measurements<Neighbours>& frames, Diagnosis& diagnosis) {
  Neighbours all;
  std::vector<std::string> names;
  for (const auto& frame : frames) {
    const Neighbours& sums = frame.result;
    all.pairs += sums.pairs;
    all.product += sums.product;
    all.product_squares += sums.product_squares;
    all.own += sums.own;
    all.next += sums.next;
    if (correlation(sums) > kCorrelated && standard_errors(sums) > kSignificant) names.push_back(frame.name);
  }
  diagnosis.facts["neighbour_correlation"] = correlation(all);
  if (names.empty()) return;
  const bool many = names.size() * 10 > frames.size();
  diagnosis.add(
      many ? Severity::problem : Severity::warning,
      fmt::format("samples of neighbouring pixels are correlated in {} (all frames: {:.3f}, independent "
                  "ones 0): the "
                  "pixel filter is wider than a pixel, or pixels share random numbers; use a box filter one "
                  "pixel wide "
                  "and another seed for every pixel",
                  frames_text(names, frames.size()), correlation(all)),
      names, {{"correlation", correlation(all)}, {"standard_errors", standard_errors(all)}});
}

}  // namespace

std::unique_ptr<Check> make_filter_check(size_t frames) {
  return FrameCheck<Neighbours, measure, conclude>::make(frames);
}

}  // namespace ld
