#include "frame/frame.h"

#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ld {

namespace {

/// Pixels from `first` on of a sample.
struct Stretch {
  int sample;
  size_t first, count;
};

/// Whether all values are in [low, high], in a form that compilers vectorise. NaN is not.
bool all_within(const float* values, size_t count, float low, float high) {
  int out = 0;
  for (size_t i = 0; i < count; ++i)
    out |= static_cast<int>(!(values[i] >= low)) | static_cast<int>(!(values[i] <= high));
  return out == 0;
}

/// Radiance, its parts and that of half resolution; all others are guides.
bool is_light(int channel) {
  return channel < kNormalOffset || (channel >= kDirectOffset && channel < kPositionOffset);
}

float least_value(int channel) {
  return is_light(channel) || channel == kIdOffset ? 0 : -kHalfMax;
}

float largest_value(int channel) {
  if (channel == kIdOffset) return kMostId;
  return is_light(channel) ? std::numeric_limits<float>::max() : kHalfMax;
}

float* alpha_of(Frame& frame, const Stretch& stretch) {
  if (frame.alpha.empty()) return nullptr;
  return frame.alpha.data() + static_cast<size_t>(stretch.sample) * frame.plane_size() + stretch.first;
}

/// Whether nothing is to be done, which is the rule: a tenth of the time of going through all planes pixel by
/// pixel. Features that the frame does not hold are 0, and their memory better untouched.
bool is_clean(Frame& frame, const Stretch& stretch) {
  for (const std::string& name : frame.features) {
    const Feature& feature = find_feature(name);
    for (int c = feature.offset; c < feature.offset + feature.channels; ++c)
      if (!all_within(frame.plane(stretch.sample, c) + stretch.first, stretch.count, least_value(c),
                      largest_value(c)))
        return false;
  }
  const float* alpha = alpha_of(frame, stretch);
  if (alpha != nullptr && !all_within(alpha, stretch.count, 0, 1)) return false;
  for (size_t part = 0; part < frame.parts.size(); ++part)
    for (int c = 0; c < 3; ++c)
      if (!all_within(frame.part_plane(part, stretch.sample, c) + stretch.first, stretch.count, -kLargestPart,
                      kLargestPart))
        return false;
  const uint8_t* valid = frame.valid_plane(stretch.sample) + stretch.first;
  return std::all_of(valid, valid + stretch.count, [](uint8_t v) { return v != 0; });
}

/// Sets the guides of a sample of so many channels that are not finite to what a ray that escaped has;
/// channel c is at sample[c * pitch]. Returns how many there were.
int64_t mend_guides(float* sample, int channels, size_t pitch) {
  int64_t mended = 0;
  for (const Feature& feature : feature_schema()) {
    if (feature.offset == kRadianceOffset || feature.offset >= channels) continue;
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

/// A part of the light is 0 where the sample does not count, and where its colour is not finite.
void mend_part(Frame& frame, size_t part, const Stretch& stretch, Faults& faults) {
  const uint8_t* valid = frame.valid_plane(stretch.sample) + stretch.first;
  const size_t pixels = frame.plane_size();
  for (size_t p = 0; p < stretch.count; ++p) {
    float* const colour = frame.part_plane(part, stretch.sample, 0) + stretch.first + p;
    bool finite = true;
    for (size_t c = 0; c < 3; ++c) finite = finite && std::isfinite(colour[c * pixels]);
    if (valid[p] != 0 && !finite) ++faults.parts;
    for (size_t c = 0; c < 3; ++c) {
      float& value = colour[c * pixels];
      value = valid[p] != 0 && finite ? std::clamp(value, -kLargestPart, kLargestPart) : 0.0F;
    }
  }
}

void mend(Frame& frame, const Stretch& stretch, Faults& faults) {
  const size_t pixels = frame.plane_size();
  uint8_t* valid = frame.valid_plane(stretch.sample) + stretch.first;
  float* const alpha = alpha_of(frame, stretch);
  for (size_t p = 0; p < stretch.count; ++p) {
    float* sample = frame.plane(stretch.sample, 0) + stretch.first + p;
    bool finite = alpha == nullptr || std::isfinite(alpha[p]);
    for (size_t c = 0; c < 3; ++c) finite = finite && std::isfinite(sample[c * pixels]);
    if (valid[p] != 0 && !finite) {
      ++faults.not_finite;
      valid[p] = 0;
    }
    if (valid[p] != 0) faults.guides += mend_guides(sample, frame.channels, pixels);
    for (int c = 0; c < frame.channels; ++c) {
      float& value = sample[static_cast<size_t>(c) * pixels];
      if (valid[p] == 0) {
        value = 0;
        continue;
      }
      if (c < 3 && value < 0) ++faults.negative;
      value = std::clamp(value, least_value(c), largest_value(c));
    }
    if (alpha != nullptr) alpha[p] = valid[p] == 0 ? 0.0F : std::clamp(alpha[p], 0.0F, 1.0F);
  }
  for (size_t part = 0; part < frame.parts.size(); ++part) mend_part(frame, part, stretch, faults);
}

}  // namespace

void* zero_pages(size_t count, size_t size) {
  void* const memory = std::calloc(count, size);  // large ones are the system's own zeros
  if (memory == nullptr) throw std::bad_alloc();
  constexpr size_t kPage = size_t{1} << 21;
  if (count * size >= 2 * kPage) {
    char* const begin = static_cast<char*>(memory);
    const size_t before = (kPage - reinterpret_cast<uintptr_t>(begin) % kPage) % kPage,
                 bytes = (count * size - before) / kPage * kPage;
    madvise(begin + before, bytes, MADV_HUGEPAGE);  // where it cannot, small pages do
  }
  return memory;
}

Faults sanitise(Frame& frame) {
  Faults faults;
  for (int s = 0; s < frame.spp; ++s) sanitise(frame, s, 0, frame.plane_size(), faults);
  return faults;
}

void sanitise(Frame& frame, int sample, size_t first, size_t count, Faults& faults) {
  constexpr size_t kStretch = 2048;  // whose planes stay in the cache
  for (size_t done = 0; done < count; done += kStretch) {
    const Stretch stretch = {sample, first + done, std::min(kStretch, count - done)};
    if (!is_clean(frame, stretch)) mend(frame, stretch, faults);
  }
}

int64_t fit_in_half(Frame& frame, int sample) {
  const size_t pixels = frame.plane_size();
  float* const radiance[3] = {frame.plane(sample, 0), frame.plane(sample, 1), frame.plane(sample, 2)};
  std::vector<float*> parts;
  for (int c = kDirectOffset; c < std::min(frame.channels, kHalfRadianceOffset); ++c)
    parts.push_back(frame.plane(sample, c));
  for (size_t part = 0; part < frame.parts.size(); ++part)
    for (int c = 0; c < 3; ++c) parts.push_back(frame.part_plane(part, sample, c));
  for (float* part : parts)
    for (size_t p = 0; p < pixels; ++p) {
      const float most = std::max({radiance[0][p], radiance[1][p], radiance[2][p]});
      if (most > kHalfMax && std::isfinite(most)) part[p] *= kHalfMax / most;
    }
  return fit_colours_in_half(radiance[0], radiance[1], radiance[2], pixels);
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

}  // namespace ld
