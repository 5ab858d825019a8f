#include "frame/frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ld {

namespace {

/// Whether a sample needs nothing done to it, which is the rule: one pass over its planes in order, a tenth
/// of the time of going through all planes pixel by pixel. NaN fails both comparisons.
bool is_clean(const Frame& frame, int s) {
  const size_t pixels = frame.plane_size();
  for (int c = 0; c < kSampleChannels; ++c) {
    const float low = c < 3 ? 0.0F : -kEscapedDepth;
    const float high = c < 3 ? std::numeric_limits<float>::max() : kEscapedDepth;
    const float* plane = frame.plane(s, c);
    bool fine = true;
    for (size_t p = 0; p < pixels; ++p) fine &= (plane[p] >= low) & (plane[p] <= high);
    if (!fine) return false;
  }
  const uint8_t* valid = frame.valid_plane(s);
  return std::all_of(valid, valid + pixels, [](uint8_t v) { return v != 0; });
}

/// Sets the guides of a sample that are not finite to what a ray that escaped has; channel c is at sample[c *
/// pitch]. Returns how many there were.
int64_t mend_guides(float* sample, size_t pitch) {
  int64_t mended = 0;
  for (const Feature& feature : feature_schema()) {
    if (feature.offset == kRadianceOffset) continue;
    float* const guide = sample + static_cast<size_t>(feature.offset) * pitch;
    bool finite = true;
    for (size_t c = 0; c < static_cast<size_t>(feature.channels); ++c)
      finite &= std::isfinite(guide[c * pitch]);
    if (finite) continue;
    ++mended;
    for (size_t c = 0; c < static_cast<size_t>(feature.channels); ++c)
      guide[c * pitch] = feature.offset == kDepthOffset ? kEscapedDepth : 0.0F;
  }
  return mended;
}

}  // namespace

Faults sanitise(Frame& frame) {
  Faults faults;
  const size_t pixels = frame.plane_size();
  for (int s = 0; s < frame.spp; ++s) {
    if (frame.alpha.empty() && is_clean(frame, s)) continue;
    uint8_t* valid = frame.valid_plane(s);
    float* const alpha = frame.alpha.empty() ? nullptr : frame.alpha.data() + static_cast<size_t>(s) * pixels;
    for (size_t p = 0; p < pixels; ++p) {
      float* sample = frame.plane(s, 0) + p;
      bool finite = alpha == nullptr || std::isfinite(alpha[p]);
      for (size_t c = 0; c < 3; ++c) finite = finite && std::isfinite(sample[c * pixels]);
      if (valid[p] != 0 && !finite) {
        ++faults.not_finite;
        valid[p] = 0;
      }
      if (valid[p] != 0) faults.guides += mend_guides(sample, pixels);
      for (size_t c = 0; c < kSampleChannels; ++c) {
        float& value = sample[c * pixels];
        if (valid[p] == 0) {
          value = 0;
        } else if (c < 3) {
          if (value < 0) ++faults.negative;
          value = std::max(value, 0.0F);
        } else {
          value = std::clamp(value, -kEscapedDepth, kEscapedDepth);
        }
      }
      if (alpha != nullptr) alpha[p] = valid[p] == 0 ? 0.0F : std::clamp(alpha[p], 0.0F, 1.0F);
    }
  }
  return faults;
}

namespace {

/// Mean over the valid samples of planes value(sample, channel).
template <class Plane>
Image mean_of(const Frame& frame, int channels, const Plane& plane) {
  Image mean(frame.width, frame.height, channels);
  for (size_t p = 0; p < frame.plane_size(); ++p) {
    double sum[3] = {0, 0, 0};
    int count = 0;
    for (int s = 0; s < frame.spp; ++s) {
      if (frame.valid_plane(s)[p] == 0) continue;
      ++count;
      for (int c = 0; c < channels; ++c) sum[c] += plane(s, c)[p];
    }
    for (int c = 0; c < channels; ++c)
      mean.plane(c)[p] = count == 0 ? 0.0F : static_cast<float>(sum[c] / count);
  }
  return mean;
}

}  // namespace

Image mean_radiance(const Frame& frame) {
  return mean_of(frame, 3, [&](int s, int c) { return frame.plane(s, c); });
}

Image mean_alpha(const Frame& frame) {
  return mean_of(
      frame, 1, [&](int s, int) { return frame.alpha.data() + static_cast<size_t>(s) * frame.plane_size(); });
}

float median_depth(const Frame& frame) {
  if (!frame.holds("depth")) return 1;
  std::vector<float> depths;
  for (int s = 0; s < frame.spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p)
      if (frame.valid_plane(s)[p] != 0 && frame.plane(s, kDepthOffset)[p] < kEscapedDepth)
        depths.push_back(frame.plane(s, kDepthOffset)[p]);
  if (depths.empty()) return 1;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  // A camera inside a surface sees depth 0; a scale of 0 would divide by zero.
  return std::max(*middle, 1e-6F);
}

}  // namespace ld
