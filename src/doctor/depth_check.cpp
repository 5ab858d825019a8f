// Depth is in scene units along the view axis, 65504 where the ray escaped.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "doctor/doctor_check.h"
#include "doctor/flat_windows.h"

namespace ld {
namespace {

// Half floats keep three digits from 6e-5 to 65504. Scenes whose middle lies beyond these lose the far half
// or the digits.
constexpr double kTooFar = 16384, kFar = 1000, kTooNear = 1e-3;
constexpr double kOtherUnit = 8;    // between the stored depth scale and the median of the depths
constexpr double kMany = 0.01;      // of a frame's samples
constexpr int64_t kLeastCut = 32;   // samples; the farthest ones of a tiny frame say nothing
constexpr double kFacing = 0.98;    // normals along the axis: of walls whose depth is one number
constexpr size_t kLeastVotes = 20;  // flat surfaces before the data set is judged by them
constexpr double kSureExponent = 0.5;

struct Depth {
  bool held = false;
  int64_t samples = 0, hits = 0, negative = 0;
  int64_t zero = 0;
  int64_t escaped_near = 0;  // no normal, yet a depth
  int64_t hit_far = 0;       // a normal, yet no depth
  double least = std::numeric_limits<double>::infinity(), largest = 0;
  int64_t cut = 0;  // at the largest depth, although the surface leads on
  double median = 0;
  double scale = 0;              // that the file says, which networks divide by
  std::vector<float> exponents;  // of the flat windows that are sure of it
};

/// Samples at the largest depth of a frame that do not face the camera. Where nothing was cut off they are
/// few, a surface's farthest edge.
int64_t count_cut(const Frame& frame, float largest) {
  int64_t cut = 0;
  for (int s = 0; s < frame.spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p) {
      if (frame.valid_plane(s)[p] == 0 || frame.plane(s, kDepthOffset)[p] != largest) continue;
      const bool faces = frame.holds("normal") &&
                         std::abs(static_cast<double>(frame.plane(s, kNormalOffset + 2)[p])) > kFacing;
      if (!faces && (frame.holds("normal") || static_cast<double>(largest) > kTooFar)) ++cut;
    }
  return cut < kLeastCut ? 0 : cut;
}

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
  found.scale = static_cast<double>(frame.info.depth_scale);
  if (found.largest > found.least) found.cut = count_cut(frame, static_cast<float>(found.largest));
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

/// One finding for the frames that `odd` holds for, named between two texts.
void judge(const All& frames, Diagnosis& diagnosis, Severity severity,
           const std::function<bool(const Depth&)>& odd, const std::string& before,
           const std::string& after) {
  std::vector<std::string> names;
  for (const auto& frame : frames)
    if (frame.result.hits > 0 && odd(frame.result)) names.push_back(frame.name);
  if (names.empty()) return;
  diagnosis.add(severity, before + frames_text(names, frames.size()) + after, names,
                {{"frames", names.size()}});
}

void conclude_unit(const All& frames, Diagnosis& diagnosis) {
  judge(
      frames, diagnosis, Severity::problem, [](const Depth& d) { return d.median > kTooFar; },
      "half of the depths of ",
      fmt::format(" are above {:g}, near the end of half floats, 65504; write metres instead of millimetres",
                  kTooFar));
  judge(
      frames, diagnosis, Severity::warning,
      [](const Depth& d) { return d.median > kFar && d.median <= kTooFar; }, "half of the depths of ",
      fmt::format(" are above {:g}: half floats end at 65504, so that what lies some tens of times as far is "
                  "lost; write metres instead of millimetres",
                  kFar));
  judge(
      frames, diagnosis, Severity::problem, [](const Depth& d) { return d.median < kTooNear; },
      "half of the depths of ",
      fmt::format(" are below {:g}, where half floats lose digits; write a smaller unit", kTooNear));
}

void conclude_normalised(const All& frames, Diagnosis& diagnosis) {
  double largest = 0;
  int64_t hits = 0;
  bool tiny = true;
  for (const auto& frame : frames) {
    const Depth& d = frame.result;
    hits += d.hits;
    largest = std::max(largest, d.largest);
    tiny = tiny && d.hits > 0 && d.median < kTooNear;
  }
  if (hits > 0 && largest <= 1 && !tiny)
    diagnosis.add(
        Severity::warning,
        fmt::format(
            "no depth is above 1 (the largest is {:.4g}): it looks normalised, by another factor in each "
            "frame perhaps; write scene units, unless the scenes are that small",
            largest),
        {}, {{"largest", largest}});
}

/// Networks see d / (d + scale), which is 1 for all depths in another unit than the scale's.
void conclude_scale(const All& frames, Diagnosis& diagnosis) {
  const auto odd = [](const Depth& d) {
    return d.median > kOtherUnit * d.scale || d.scale > kOtherUnit * d.median;
  };
  const auto first = std::find_if(frames.begin(), frames.end(), [&](const auto& frame) {
    return frame.result.hits > 0 && odd(frame.result);
  });
  if (first == frames.end()) return;
  judge(frames, diagnosis, Severity::problem, odd, "ldDepthScale is in another unit than the depths of ",
        fmt::format(" (in {} it is {:.4g}, and their median {:.4g}); write the median, or no ldDepthScale",
                    first->name, first->result.scale, first->result.median));
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
  count_faults(
      frames, diagnosis, &Depth::cut, "depths are cut off at the largest of their frame in samples",
      "write a larger unit, such as metres, so that depth stays below 65504, and 65504 only where the "
      "ray escaped");
  conclude_unit(frames, diagnosis);
  conclude_normalised(frames, diagnosis);
  conclude_scale(frames, diagnosis);
  conclude_axis(frames, diagnosis);
}

}  // namespace

std::unique_ptr<Check> make_depth_check(size_t frames) {
  return FrameCheck<Depth, measure, conclude>::make(frames);
}

}  // namespace ld
