// Depth is in scene units along the view axis, 65504 where the ray escaped.
#include <algorithm>
#include <cmath>
#include <limits>

#include "doctor/check.h"
#include "doctor/flat_windows.h"

namespace ld {
namespace {

// Half floats keep three digits from 6e-5 to 65504. Scenes whose middle lies beyond these lose the far half
// or the digits.
constexpr double kTooFar = 16384, kTooNear = 1e-3;
constexpr double kMany = 0.01;      // of a frame's samples
constexpr size_t kLeastVotes = 20;  // flat surfaces before the data set is judged by them
constexpr double kSureExponent = 0.5;

struct Depth {
  bool held = false;
  int64_t samples = 0, hits = 0, negative = 0;
  int64_t zero = 0;
  int64_t escaped_near = 0;  // no normal, yet a depth
  int64_t hit_far = 0;       // a normal, yet no depth
  double least = std::numeric_limits<double>::infinity(), largest = 0;
  double median = 0;
  std::vector<float> exponents;  // of the flat windows that are sure of it
};

Depth measure(const Evidence& evidence) {
  const Frame& frame = evidence.frame;
  Depth found;
  found.held = frame.holds("depth");
  if (!found.held) return found;
  const bool normals = frame.holds("normal");
  for (int s = 0; s < frame.spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p) {
      if (frame.valid_plane(s)[p] == 0) continue;
      const double depth = frame.plane(s, kDepthOffset)[p];
      ++found.samples;
      found.negative += depth < 0 ? 1 : 0;
      found.zero += !normals && depth == 0 ? 1 : 0;  // normals say more about what escaped
      const bool escaped = depth >= kEscapedDepth;
      if (normals) {
        const bool no_normal = frame.plane(s, kNormalOffset)[p] == 0.0F &&
                               frame.plane(s, kNormalOffset + 1)[p] == 0.0F &&
                               frame.plane(s, kNormalOffset + 2)[p] == 0.0F;
        found.escaped_near += no_normal && !escaped ? 1 : 0;
        found.hit_far += !no_normal && escaped ? 1 : 0;
      }
      if (escaped) continue;
      ++found.hits;
      found.least = std::min(found.least, depth);
      found.largest = std::max(found.largest, depth);
    }
  found.median = static_cast<double>(median_depth(frame));
  for (const FlatWindow& window : flat_windows(evidence))
    if (window.exponent_error < kSureExponent) found.exponents.push_back(static_cast<float>(window.exponent));
  return found;
}

using All = Measurements<Depth>;

/// One finding for the frames of which more than kMany samples have the fault.
void count_faults(const All& frames, Diagnosis& diagnosis, int64_t Depth::*fault, const std::string& what,
                  const std::string& advice) {
  int64_t sum = 0, of = 0;
  std::vector<std::string> names;
  for (const auto& frame : frames) {
    const Depth& d = frame.result;
    sum += d.*fault;
    of += d.samples;
    if (static_cast<double>(d.*fault) > kMany * static_cast<double>(d.samples)) names.push_back(frame.name);
  }
  if (names.empty()) return;
  diagnosis.add(Severity::problem,
                fmt::format("{} of {} ({} of all samples); {}", what, frames_text(names, frames.size()),
                            share_text(static_cast<double>(sum), static_cast<double>(of)), advice),
                names, {{"samples", sum}, {"of", of}});
}

float median_of(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void conclude_axis(const All& frames, Diagnosis& diagnosis) {
  std::vector<float> exponents;
  std::vector<std::string> names;
  for (const auto& frame : frames) {
    const std::vector<float>& here = frame.result.exponents;
    exponents.insert(exponents.end(), here.begin(), here.end());
    if (!here.empty() && static_cast<double>(median_of(here)) > kSureExponent) names.push_back(frame.name);
  }
  if (exponents.size() < kLeastVotes) {
    diagnosis.facts["depth_axis"] = "not checked; needs normals, ldCamera and flat surfaces";
    return;
  }
  const double median = static_cast<double>(median_of(exponents));
  diagnosis.facts["depth_axis"] = {{"flat_surfaces", exponents.size()}, {"exponent", median}};
  if (median <= kSureExponent) return;
  diagnosis.add(
      Severity::problem,
      fmt::format("depth is the distance along the ray in {}: {} flat surfaces have it curved with the "
                  "exponent {:.2f} "
                  "(0 along the axis, 1 along the ray); multiply by the cosine between ray and view axis",
                  frames_text(names, frames.size()), exponents.size(), median),
      names, diagnosis.facts["depth_axis"]);
}

void conclude_unit(const All& frames, Diagnosis& diagnosis) {
  std::vector<std::string> far, near;
  double largest = 0;
  int64_t hits = 0;
  for (const auto& frame : frames) {
    const Depth& d = frame.result;
    hits += d.hits;
    largest = std::max(largest, d.largest);
    if (d.hits > 0 && d.median > kTooFar) far.push_back(frame.name);
    if (d.hits > 0 && d.median < kTooNear) near.push_back(frame.name);
  }
  if (!far.empty())
    diagnosis.add(Severity::problem,
                  fmt::format("half of the depths of {} are above {:g}, near the end of half floats, "
                              "65504; write metres instead of millimetres",
                              frames_text(far, frames.size()), kTooFar),
                  far, {{"frames", far.size()}});
  if (!near.empty())
    diagnosis.add(Severity::problem,
                  fmt::format("half of the depths of {} are below {:g}, where half floats lose digits; "
                              "write a smaller unit",
                              frames_text(near, frames.size()), kTooNear),
                  near, {{"frames", near.size()}});
  if (hits > 0 && largest <= 1 && near.size() < frames.size())
    diagnosis.add(
        Severity::warning,
        fmt::format(
            "no depth is above 1 (the largest is {:.4g}): it looks normalised, by another factor in each "
            "frame perhaps; write scene units, unless the scenes are that small",
            largest),
        {}, {{"largest", largest}});
}

void conclude(const All& all, Diagnosis& diagnosis) {
  All frames;
  for (const auto& frame : all)
    if (frame.result.held) frames.push_back(frame);
  if (frames.empty()) return;
  count_faults(frames, diagnosis, &Depth::negative, "depths are negative in samples",
               "+z points towards the camera, but depth counts away from it: negate it");
  count_faults(frames, diagnosis, &Depth::escaped_near,
               "rays that escaped (no normal) have a depth other than 65504 in samples",
               "write 65504 there, or the normal if they hit something");
  count_faults(frames, diagnosis, &Depth::hit_far,
               "samples with a normal have depth 65504, as if escaped, in samples",
               "write a larger unit, such as metres, so that depth stays below 65504");
  count_faults(frames, diagnosis, &Depth::zero, "depth is 0 in samples", "write 65504 where the ray escaped");
  conclude_unit(frames, diagnosis);
  conclude_axis(frames, diagnosis);
}

}  // namespace

std::unique_ptr<Check> make_depth_check(size_t frames) {
  return FrameCheck<Depth, measure, conclude>::make(frames);
}

}  // namespace ld
