// Normals must be of unit length and in view space.
#include <algorithm>
#include <array>
#include <cmath>

#include "doctor/doctor_check.h"
#include "doctor/flat_windows.h"

namespace ld {
namespace {

constexpr double kUnitTolerance = 0.02;  // half floats leave 0.001
// Shading normals bend away from the camera near silhouettes, a little and in few places.
constexpr double kAwayCosine = -0.1;
constexpr double kManyAway = 0.05;     // of a frame's hits; the project's own frames have less than 0.5 %
constexpr double kManyNotUnit = 0.01;  // of all hits
constexpr int64_t kLeastHits = 500;    // a frame with fewer says nothing
// Where nothing says how wide the picture is, a normal must face away from every camera up to 90 degrees
// high.
constexpr double kWidestTangent = 1;
// Flat surfaces whose stored normal is more than 25 degrees off what their depth shows.
constexpr double kAgreement = 0.9;
constexpr size_t kLeastWindows = 4;
constexpr double kFlipped =
    0.95;  // mean cosine that one choice of signs reaches when signs are what is wrong

struct Normals {
  int64_t hits = 0, not_unit = 0, away = 0, positive = 0;
  bool held = false, camera_known = false;
  size_t windows = 0;
  double median_cosine = 1;          // of the flat windows
  std::array<double, 3> products{};  // FlatWindow::normal_products, summed
};

/// The cosine of the normal to the direction towards the camera, or the largest one for all fields of view.
double facing(const Evidence& evidence, const double n[3], int x, int y) {
  const Frame& frame = evidence.frame;
  const double centred_x = x + 0.5 - 0.5 * frame.width, centred_y = 0.5 * frame.height - y - 0.5;
  const double focal = evidence.focal_pixels.value_or(0.5 * frame.height / kWidestTangent);
  const double dx = -centred_x / focal, dy = -centred_y / focal;
  const double cosine = (n[0] * dx + n[1] * dy + n[2]) / std::sqrt(dx * dx + dy * dy + 1);
  return evidence.focal_pixels ? cosine : std::max(cosine, n[2]);
}

Normals measure(const Evidence& evidence) {
  const Frame& frame = evidence.frame;
  Normals found;
  found.held = frame.holds("normal");
  found.camera_known = evidence.focal_pixels.has_value();
  if (!found.held) return found;
  for (int s = 0; s < frame.spp; ++s)
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x) {
        const size_t p = static_cast<size_t>(y) * static_cast<size_t>(frame.width) + static_cast<size_t>(x);
        const double n[3] = {frame.plane(s, kNormalOffset)[p], frame.plane(s, kNormalOffset + 1)[p],
                             frame.plane(s, kNormalOffset + 2)[p]};
        const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        if (frame.valid_plane(s)[p] == 0 || length <= 0) continue;
        ++found.hits;
        if (std::abs(length - 1) > kUnitTolerance) ++found.not_unit;
        if (n[0] >= 0 && n[1] >= 0 && n[2] >= 0) ++found.positive;
        if (facing(evidence, n, x, y) < kAwayCosine * length) ++found.away;
      }
  std::vector<double> cosines;
  for (const FlatWindow& window : flat_windows(evidence)) {
    cosines.push_back(window.normal_cosine());
    for (size_t c = 0; c < 3; ++c) found.products[c] += window.normal_products[c];
  }
  found.windows = cosines.size();
  if (!cosines.empty()) {
    const auto middle = cosines.begin() + static_cast<std::ptrdiff_t>(cosines.size() / 2);
    std::nth_element(cosines.begin(), middle, cosines.end());
    found.median_cosine = *middle;
  }
  return found;
}

void conclude_length(const Measurements<Normals>& frames, Diagnosis& diagnosis) {
  int64_t hits = 0, not_unit = 0, positive = 0;
  std::vector<std::string> names;
  for (const auto& frame : frames) {
    hits += frame.result.hits;
    not_unit += frame.result.not_unit;
    positive += frame.result.positive;
    if (frame.result.not_unit > 0) names.push_back(frame.name);
  }
  if (static_cast<double>(not_unit) <= kManyNotUnit * static_cast<double>(hits)) return;
  const bool encoded = static_cast<double>(positive) > 0.99 * static_cast<double>(hits);
  diagnosis.add(
      Severity::problem,
      fmt::format(
          "{} of the normals are not of unit length in {}; {}",
          share_text(static_cast<double>(not_unit), static_cast<double>(hits)),
          frames_text(names, frames.size()),
          encoded ? "none has a negative component: they look like colours, (n + 1) / 2; write 2 c - 1"
                  : "normals averaged over a pixel shrink at edges: write those of each sample, normalised"),
      names, {{"not_unit", not_unit}, {"of", hits}, {"looks_encoded", encoded}});
}

/// "z", "x and z", ...: the axes whose other sign makes the stored normals those that depth shows; "" when no
/// choice of signs does.
std::string flipped_axes(const std::array<double, 3>& products, size_t windows) {
  double agreement = 0;
  std::string axes;
  for (size_t c = 0; c < 3; ++c) {
    agreement += std::abs(products[c]);
    if (products[c] < 0) axes += (axes.empty() ? "" : " and ") + std::string(1, "xyz"[c]);
  }
  return agreement > kFlipped * static_cast<double>(windows) ? axes : "";
}

void conclude(const Measurements<Normals>& frames, Diagnosis& diagnosis) {
  conclude_length(frames, diagnosis);
  int64_t hits = 0, away = 0;
  size_t windows = 0;
  std::array<double, 3> products{};
  std::vector<std::string> names;
  std::vector<double> cosines;
  size_t judged = 0;
  for (const auto& frame : frames) {
    const Normals& n = frame.result;
    if (n.hits < kLeastHits) continue;
    ++judged;
    hits += n.hits;
    away += n.away;
    windows += n.windows;
    for (size_t c = 0; c < 3; ++c) products[c] += n.products[c];
    const bool disagrees = n.windows >= kLeastWindows && n.median_cosine < kAgreement;
    if (n.windows >= kLeastWindows) cosines.push_back(n.median_cosine);
    if (disagrees || static_cast<double>(n.away) > kManyAway * static_cast<double>(n.hits))
      names.push_back(frame.name);
  }
  std::sort(cosines.begin(), cosines.end());
  const double cosine = cosines.empty() ? 1 : cosines[cosines.size() / 2];
  diagnosis.facts["normals"] = {
      {"hits", hits},
      {"facing_away", hits > 0 ? static_cast<double>(away) / static_cast<double>(hits) : 0},
      {"flat_surfaces", windows},
      {"cosine_to_depth", cosine}};
  if (names.empty()) return;
  // A few frames may look at something odd, the inside of glass for instance; a data set does not.
  const bool many = names.size() * 10 > judged;
  const std::string flipped = flipped_axes(products, windows);
  diagnosis.add(
      many ? Severity::problem : Severity::warning,
      fmt::format(
          "normals are not in view space in {}: {} of all hits face away from the camera{}; {}",
          frames_text(names, judged), share_text(static_cast<double>(away), static_cast<double>(hits)),
          cosines.empty() ? ""
                          : fmt::format(", and on flat surfaces the cosine to the normal that depth shows is "
                                        "{:.2f} (median)",
                                        cosine),
          !flipped.empty()
              ? fmt::format("+x points right, +y up, +z towards the camera: negate {}", flipped)
              : "they look like world space: turn them by the inverse of the camera's rotation (+x right, "
                "+y up, +z towards the camera)"),
      names, diagnosis.facts["normals"]);
}

}  // namespace

std::unique_ptr<Check> make_normal_check(size_t frames) {
  return FrameCheck<Normals, measure, conclude>::make(frames);
}

}  // namespace ld
