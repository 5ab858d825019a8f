// What classical filters read: parts of radiance that add up to it, ids that are numbers of objects, cameras
// that turn and move and do no more.
#include <algorithm>
#include <cmath>

#include "doctor/doctor_check.h"

namespace ld {
namespace {

// Three parts and their sum, each rounded to half floats: twice 2^-11 of the sum, and their smallest steps.
constexpr double kRelative = 2.0 / 2048, kSmallest = 4.0 / (1 << 24);
constexpr double kSkew = 1e-3;  // of axes that should be of one length and at right angles
constexpr double kFew = 1e-3;   // of the samples: reported as a warning

struct FilterGuides {
  int64_t samples = 0;
  bool parts = false, ids = false;
  int64_t unequal = 0;             // samples whose parts do not add up
  double sum = 0, radiance = 0;    // of the parts and of what they should be, over these
  int64_t broken = 0, beyond = 0;  // ids that are no whole numbers, at the bound
  int64_t nameless = 0, hits = 0, named = 0, escaped = 0;  // ids 0 on surfaces; not 0 where the ray escaped
  bool skewed = false;
};

void look_at_parts(const Frame& frame, int s, size_t p, FilterGuides& found) {
  bool equal = true;
  double sum = 0, radiance = 0;
  for (int c = 0; c < 3; ++c) {
    const double whole = frame.plane(s, c)[p], parts = double{frame.plane(s, kDirectOffset + c)[p]} +
                                                       frame.plane(s, kIndirectOffset + c)[p] +
                                                       frame.plane(s, kEmissionOffset + c)[p];
    equal = equal && std::abs(parts - whole) <= kRelative * std::max(parts, whole) + kSmallest;
    sum += parts;
    radiance += whole;
  }
  if (equal) return;
  ++found.unequal;
  found.sum += sum;
  found.radiance += radiance;
}

void look_at_id(const Frame& frame, int s, size_t p, FilterGuides& found) {
  const float id = frame.plane(s, kIdOffset)[p];
  if (id != std::floor(id)) ++found.broken;
  if (id >= kMostId) ++found.beyond;
  if (!frame.holds("depth")) return;
  const bool escaped = frame.plane(s, kDepthOffset)[p] >= kEscapedDepth;
  ++(escaped ? found.escaped : found.hits);
  if (escaped && id != 0) ++found.named;
  if (!escaped && id == 0) ++found.nameless;
}

bool is_skewed(const Matrix4& world_to_camera) {
  const auto product = [&](size_t a, size_t b) {
    double sum = 0;
    for (size_t i = 0; i < 3; ++i) sum += double{world_to_camera[4 * i + a]} * world_to_camera[4 * i + b];
    return sum;
  };
  const double size = product(0, 0);
  double most = 0;
  for (size_t a = 0; a < 3; ++a)
    for (size_t b = 0; b < 3; ++b) most = std::max(most, std::abs(product(a, b) - (a == b ? size : 0.0)));
  return !(size > 0) || most > kSkew * size;
}

FilterGuides measure(const Evidence& evidence) {
  const Frame& frame = evidence.frame;
  FilterGuides found;
  found.parts = frame.holds("direct") && frame.holds("indirect") && frame.holds("emission");
  found.ids = frame.holds("id");
  found.skewed = frame.info.world_to_camera && is_skewed(*frame.info.world_to_camera);
  if (!found.parts && !found.ids) return found;
  for (int s = 0; s < frame.spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p) {
      if (frame.valid_plane(s)[p] == 0) continue;
      ++found.samples;
      if (found.parts) look_at_parts(frame, s, p, found);
      if (found.ids) look_at_id(frame, s, p, found);
    }
  return found;
}

using Frames = Measurements<FilterGuides>;

/// Says so where `count` of the frames is above 0.
template <class Text>
void report(const Frames& frames, int64_t FilterGuides::*count, int64_t FilterGuides::*of, Severity severity,
            Diagnosis& diagnosis, const Text& text) {
  std::vector<std::string> names;
  int64_t faults = 0, all = 0;
  for (const auto& frame : frames) {
    faults += frame.result.*count;
    all += frame.result.*of;
    if (frame.result.*count > 0) names.push_back(frame.name);
  }
  if (names.empty()) return;
  const bool few = static_cast<double>(faults) <= kFew * static_cast<double>(all);
  diagnosis.add(few ? Severity::warning : severity,
                text(share_text(static_cast<double>(faults), static_cast<double>(all)),
                     frames_text(names, frames.size())),
                names, {{"samples", faults}, {"of", all}});
}

void conclude(const Frames& frames, Diagnosis& diagnosis) {
  double sum = 0, radiance = 0;
  std::vector<std::string> skewed;
  for (const auto& frame : frames) {
    sum += frame.result.sum;
    radiance += frame.result.radiance;
    if (frame.result.skewed) skewed.push_back(frame.name);
  }
  report(
      frames, &FilterGuides::unequal, &FilterGuides::samples, Severity::problem, diagnosis,
      [&](const auto& share, const auto& where) {
        return fmt::format(
            "direct, indirect and emission do not add up to radiance in {} of the samples ({}): {:.3g} times "
            "as "
            "much there; all light belongs to one of them, the background to emission, and colours to light",
            share, where, radiance > 0 ? sum / radiance : 0.0);
      });
  report(frames, &FilterGuides::broken, &FilterGuides::samples, Severity::problem, diagnosis,
         [](const auto& share, const auto& where) {
           return fmt::format(
               "id is no whole number in {} of the samples ({}): it must not be filtered or averaged over "
               "the pixel; "
               "write it for each sample, as floats",
               share, where);
         });
  report(frames, &FilterGuides::beyond, &FilterGuides::samples, Severity::problem, diagnosis,
         [](const auto& share, const auto& where) {
           return fmt::format(
               "id is {:.0f} or more in {} of the samples ({}), where floats no longer tell neighbours "
               "apart: number "
               "the objects anew",
               kMostId, share, where);
         });
  report(
      frames, &FilterGuides::nameless, &FilterGuides::hits, Severity::warning, diagnosis,
      [](const auto& share, const auto& where) {
        return fmt::format(
            "id is 0, which is no object, in {} of the samples that show a surface ({}): give all objects an "
            "index above 0, or filters take them for one",
            share, where);
      });
  report(frames, &FilterGuides::named, &FilterGuides::escaped, Severity::warning, diagnosis,
         [](const auto& share, const auto& where) {
           return fmt::format(
               "id is not 0 in {} of the samples whose ray escaped ({}): 0 stands for no object", share,
               where);
         });
  if (!skewed.empty())
    diagnosis.add(
        Severity::problem,
        fmt::format("the attribute worldToCamera scales unevenly or shears in {}: normals cannot be "
                    "turned to the world with it; write a rotation and a translation",
                    frames_text(skewed, frames.size())),
        skewed, {});
}

}  // namespace

std::unique_ptr<Check> make_filter_guide_check(size_t frames) {
  return FrameCheck<FilterGuides, measure, conclude>::make(frames);
}

}  // namespace ld
