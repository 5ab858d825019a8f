// Guides belong to the sample. Many renderers write them averaged over the pixel, the same in every sample.
#include <cmath>

#include "doctor/doctor_check.h"

namespace ld {
namespace {

// Where depth changes by more than this from one pixel to the next, the samples inside a pixel differ too,
// even as half floats (2^-11).
constexpr double kSlope = 4e-3;
constexpr double kMost = 0.9;  // of such pixels
constexpr int64_t kLeastPixels = 100;

struct Guides {
  int64_t sloped = 0, repeated = 0;
};

Guides measure(const Evidence& evidence) {
  const Frame& frame = evidence.frame;
  Guides found;
  if (!frame.holds("depth") || frame.spp < 2) return found;
  const auto width = static_cast<size_t>(frame.width);
  for (size_t y = 0; y < static_cast<size_t>(frame.height); ++y)
    for (size_t x = 0; x + 1 < width; ++x) {
      const size_t p = y * width + x;
      const double here = frame.plane(0, kDepthOffset)[p], next = frame.plane(0, kDepthOffset)[p + 1];
      if (here >= kEscapedDepth || next >= kEscapedDepth || std::abs(next - here) <= kSlope * here) continue;
      bool complete = true, repeated = true;
      for (int s = 0; s < frame.spp; ++s) {
        complete = complete && frame.valid_plane(s)[p] != 0;
        repeated = repeated && frame.plane(s, kDepthOffset)[p] == frame.plane(0, kDepthOffset)[p];
      }
      if (!complete) continue;
      ++found.sloped;
      found.repeated += repeated ? 1 : 0;
    }
  return found;
}

void conclude(const Measurements<Guides>& frames, Diagnosis& diagnosis) {
  std::vector<std::string> names;
  int64_t sloped = 0, repeated = 0;
  for (const auto& frame : frames) {
    const Guides& g = frame.result;
    sloped += g.sloped;
    repeated += g.repeated;
    if (g.sloped >= kLeastPixels && static_cast<double>(g.repeated) > kMost * static_cast<double>(g.sloped))
      names.push_back(frame.name);
  }
  if (names.empty()) return;
  diagnosis.add(
      Severity::warning,
      fmt::format(
          "guides are averaged over the pixel in {}: depth is the same in all samples of {} of the pixels "
          "that "
          "it changes across; networks on samples live on each sample's own guides, so render one sample a "
          "pixel at a time",
          frames_text(names, frames.size()),
          share_text(static_cast<double>(repeated), static_cast<double>(sloped))),
      names, {{"repeated", repeated}, {"of", sloped}});
}

}  // namespace

std::unique_ptr<Check> make_guide_check(size_t frames) {
  return FrameCheck<Guides, measure, conclude>::make(frames);
}

}  // namespace ld
