// Fireflies: samples far brighter than what they are samples of, and pixels of references that stand out of
// their surroundings although the samples do not.
#include <algorithm>
#include <array>
#include <cmath>

#include "doctor/doctor_check.h"

namespace ld {
namespace {

// A sample is a firefly when it is brighter than this many times the brightest reference pixel of the 3 x 3
// around it. A path that is 100 times too bright is found one time in a hundred at most (Markov), so a few
// are what a path tracer makes of glass and small lights; they spoil a data set when they carry its energy.
constexpr double kBrighter = 100;
// Share of all radiance in fireflies, and of samples: more than this and training sees little else. The
// references of the project's own data sets, which have caustics, stay a factor of ten below.
constexpr double kMuchEnergy = 0.1;
// A pixel of a reference this many times brighter than its brightest neighbour, and than the median of its
// own samples, was hit by a path or two and is no small lamp.
constexpr double kReferenceBrighter = 10;

// References at 32 samples a pixel have 6e-4 such pixels, those of the quick recipe, at 64, 1.5e-4.
constexpr double kFewReference = 2e-3, kManyReference = 5e-3;

struct Fireflies {
  int64_t samples = 0, fireflies = 0;
  double energy = 0, firefly_energy = 0;
  int64_t reference_pixels = 0, reference_fireflies = 0;
};

double mean_of(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += static_cast<double>(value);
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

/// The largest of the 3 x 3 around the pixel, without the pixel itself unless `self`.
float largest_around(const std::vector<float>& plane, int width, int height, int x, int y, bool self) {
  float largest = 0;
  for (int j = std::max(y - 1, 0); j <= std::min(y + 1, height - 1); ++j)
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, width - 1); ++i)
      if (self || i != x || j != y)
        largest = std::max(
            largest, plane[static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i)]);
  return largest;
}

float median_sample(const Evidence& evidence, size_t pixel, std::vector<float>& buffer) {
  buffer.clear();
  for (int s = 0; s < evidence.frame.spp; ++s)
    if (evidence.frame.valid_plane(s)[pixel] != 0) buffer.push_back(evidence.brightness_of(s)[pixel]);
  if (buffer.empty()) return 0;
  const auto middle = buffer.begin() + static_cast<std::ptrdiff_t>(buffer.size() / 2);
  std::nth_element(buffer.begin(), middle, buffer.end());
  return *middle;
}

/// What stands in for the reference where there is none: the median of the samples of the 3 x 3 around.
std::vector<float> local_median(const Evidence& evidence) {
  const Frame& frame = evidence.frame;
  std::vector<float> medians(frame.plane_size()), smooth(frame.plane_size()), buffer;
  for (size_t p = 0; p < medians.size(); ++p) medians[p] = median_sample(evidence, p, buffer);
  return medians;
}

Fireflies measure(const Evidence& evidence) {
  const Frame& frame = evidence.frame;
  const bool referenced = evidence.reference.has_value();
  const std::vector<float> truth = referenced ? evidence.reference_brightness : local_median(evidence);
  const double floor = kDarkShare * mean_of(referenced ? truth : evidence.mean_brightness);
  Fireflies found;
  std::vector<float> buffer;
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      const size_t p = static_cast<size_t>(y) * static_cast<size_t>(frame.width) + static_cast<size_t>(x);
      const double limit =
          kBrighter *
          std::max(static_cast<double>(largest_around(truth, frame.width, frame.height, x, y, true)), floor);
      for (int s = 0; s < frame.spp; ++s) {
        if (frame.valid_plane(s)[p] == 0) continue;
        const double value = evidence.brightness_of(s)[p];
        ++found.samples;
        found.energy += value;
        if (value <= limit || limit <= 0) continue;
        ++found.fireflies;
        found.firefly_energy += value;
      }
      if (!referenced) continue;
      ++found.reference_pixels;
      const double around =
          std::max(static_cast<double>(largest_around(truth, frame.width, frame.height, x, y, false)), floor);
      if (static_cast<double>(truth[p]) > kReferenceBrighter * around && around > 0 &&
          static_cast<double>(truth[p]) >
              kReferenceBrighter * static_cast<double>(median_sample(evidence, p, buffer)))
        ++found.reference_fireflies;
    }
  return found;
}

void conclude(const Measurements<Fireflies>& frames, Diagnosis& diagnosis) {
  Fireflies sum;
  std::vector<std::string> names, reference_names;
  for (const auto& frame : frames) {
    const Fireflies& f = frame.result;
    sum.samples += f.samples;
    sum.fireflies += f.fireflies;
    sum.energy += f.energy;
    sum.firefly_energy += f.firefly_energy;
    sum.reference_pixels += f.reference_pixels;
    sum.reference_fireflies += f.reference_fireflies;
    if (f.firefly_energy > kMuchEnergy * f.energy) names.push_back(frame.name);
    if (f.reference_fireflies > 0) reference_names.push_back(frame.name);
  }
  diagnosis.facts["fireflies"] = {
      {"samples", sum.fireflies},
      {"share_of_samples",
       sum.samples > 0 ? static_cast<double>(sum.fireflies) / static_cast<double>(sum.samples) : 0},
      {"share_of_radiance", sum.energy > 0 ? sum.firefly_energy / sum.energy : 0},
      {"reference_pixels", sum.reference_fireflies}};
  if (!names.empty()) {
    const bool everywhere = sum.firefly_energy > kMuchEnergy * sum.energy;
    diagnosis.add(
        everywhere ? Severity::problem : Severity::warning,
        fmt::format(
            "samples more than {:g} times brighter than the reference around them carry more than {:g} % of "
            "the radiance of {} (all frames: {} samples, {} of them, {} of the radiance); clamp indirect "
            "light in the renderer, or find the light or material that makes them",
            kBrighter, 100 * kMuchEnergy, frames_text(names, frames.size()), sum.fireflies,
            share_text(static_cast<double>(sum.fireflies), static_cast<double>(sum.samples)),
            share_text(sum.firefly_energy, sum.energy)),
        names, diagnosis.facts["fireflies"]);
  }
  if (static_cast<double>(sum.reference_fireflies) <=
      kFewReference * static_cast<double>(sum.reference_pixels))
    return;
  const bool many = static_cast<double>(sum.reference_fireflies) >
                    kManyReference * static_cast<double>(sum.reference_pixels);
  diagnosis.add(
      many ? Severity::problem : Severity::warning,
      fmt::format(
          "{} reference pixels ({}) in {} are more than {:g} times brighter than all their neighbours and "
          "than the median of their samples; networks learn such noise: render the references with more "
          "samples",
          sum.reference_fireflies,
          share_text(static_cast<double>(sum.reference_fireflies), static_cast<double>(sum.reference_pixels)),
          frames_text(reference_names, frames.size()), kReferenceBrighter),
      reference_names, {{"reference_pixels", sum.reference_fireflies}, {"of", sum.reference_pixels}});
}

}  // namespace

std::unique_ptr<Check> make_firefly_check(size_t frames) {
  return FrameCheck<Fireflies, measure, conclude>::make(frames);
}

}  // namespace ld
