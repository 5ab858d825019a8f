// The range of every feature, and numbers that its unit does not allow.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "doctor/doctor_check.h"

namespace ld {
namespace {

struct Range {
  int64_t count = 0;
  double least = std::numeric_limits<double>::infinity(), largest = -std::numeric_limits<double>::infinity();
  double sum = 0;
  int64_t below = 0, above = 0;  // samples beyond the limits of the unit
};

/// What the unit of a feature allows (docs/data_format.md), with room for the rounding of half floats.
struct Limits {
  const char* feature;
  double least, largest;
  Severity severity;
  const char* advice;
};
constexpr double kRounding = 2e-3;
constexpr Limits kLimits[] = {
    {"albedo", -kRounding, 1 + kRounding, Severity::problem,
     "albedo is the diffuse reflectance, from 0 to 1: leave lights out of it, and undo a colour space, "
     "exposure or "
     "intensity"},
    {"specular", -kRounding, 1 + kRounding, Severity::problem,
     "the specular colour is a reflectance, from 0 to 1: undo a colour space, exposure or intensity"},
    {"roughness", -kRounding, 1 + kRounding, Severity::problem,
     "roughness goes from 0, a mirror, to 1, diffuse"},
    {"lens", -1 - kRounding, 1 + kRounding, Severity::problem,
     "lens positions lie on the unit disk: divide by the radius of the lens"},
    {"time", -kRounding, 1 + kRounding, Severity::problem,
     "time goes from 0, the shutter's opening, to 1, its closing: subtract the opening, divide by the "
     "interval"},
    // A sample that crosses a whole 16k picture within one exposure: the unit is something else.
    {"motion", -16384, 16384, Severity::warning, "motion is in pixels over the shutter interval"},
};
// Of a feature's samples: fewer beyond the limits are a material or two, reported without being a problem.
constexpr double kFew = 1e-3;

using Ranges = std::map<std::string, Range>;

const Limits* limits_of(const std::string& feature) {
  for (const Limits& limits : kLimits)
    if (feature == limits.feature) return &limits;
  return nullptr;
}

Ranges measure(const Evidence& evidence) {
  const Frame& frame = evidence.frame;
  Ranges ranges;
  for (const std::string& name : frame.features) {
    const Feature& feature = find_feature(name);
    const Limits* limits = limits_of(name);
    Range& range = ranges[name];
    for (int s = 0; s < frame.spp; ++s)
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        if (frame.valid_plane(s)[p] == 0) continue;
        // A ray that escaped has no depth, so it does not count in the range.
        if (feature.offset == kDepthOffset && frame.plane(s, kDepthOffset)[p] >= kEscapedDepth) continue;
        bool below = false, above = false;
        for (int c = 0; c < feature.channels; ++c) {
          const double value = frame.plane(s, feature.offset + c)[p];
          range.least = std::min(range.least, value);
          range.largest = std::max(range.largest, value);
          range.sum += value / feature.channels;
          below = below || (limits != nullptr && value < limits->least);
          above = above || (limits != nullptr && value > limits->largest);
        }
        ++range.count;
        range.below += below ? 1 : 0;
        range.above += above ? 1 : 0;
      }
  }
  return ranges;
}

void add(Range& sum, const Range& range) {
  sum.count += range.count;
  sum.least = std::min(sum.least, range.least);
  sum.largest = std::max(sum.largest, range.largest);
  sum.sum += range.sum;
  sum.below += range.below;
  sum.above += range.above;
}

void conclude(const Measurements<Ranges>& frames, Diagnosis& diagnosis) {
  std::map<std::string, Range> all;
  for (const auto& frame : frames)
    for (const auto& [name, range] : frame.result) add(all[name], range);
  nlohmann::ordered_json facts = nlohmann::ordered_json::object();
  for (const std::string& name : feature_names())
    if (const auto it = all.find(name); it != all.end() && it->second.count > 0)
      facts[name] = {{"min", it->second.least},
                     {"max", it->second.largest},
                     {"mean", it->second.sum / static_cast<double>(it->second.count)}};
  diagnosis.facts["ranges"] = facts;

  for (const Limits& limits : kLimits) {
    const auto it = all.find(limits.feature);
    if (it == all.end()) continue;
    const Range& range = it->second;
    const int64_t beyond = range.below + range.above;
    if (beyond == 0) continue;
    std::vector<std::string> names;
    for (const auto& frame : frames) {
      const auto here = frame.result.find(limits.feature);
      if (here != frame.result.end() && here->second.below + here->second.above > 0)
        names.push_back(frame.name);
    }
    const bool many = static_cast<double>(beyond) > kFew * static_cast<double>(range.count);
    const double least = std::round(limits.least), largest = std::round(limits.largest);
    diagnosis.add(
        many ? limits.severity : Severity::warning,
        fmt::format(
            "'{}' of {} samples ({}) in {} lies beyond {:g} to {:g} (it goes from {:.4g} to {:.4g}); {}",
            limits.feature, beyond, share_text(static_cast<double>(beyond), static_cast<double>(range.count)),
            frames_text(names, frames.size()), least, largest, range.least, range.largest, limits.advice),
        names,
        {{"feature", limits.feature},
         {"below", range.below},
         {"above", range.above},
         {"of", range.count},
         {"min", range.least},
         {"max", range.largest}});
  }
}

}  // namespace

std::unique_ptr<Check> make_range_check(size_t frames) {
  return FrameCheck<Ranges, measure, conclude>::make(frames);
}

}  // namespace ld
