// A frame of samples and an image, in memory. Planar: a channel of a sample is one contiguous plane.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "frame/camera_matrices.h"
#include "frame/schema.h"

namespace ld {

/// [channels, height, width], row 0 on top.
struct Image {
  int width = 0, height = 0, channels = 0;
  std::vector<float> pixels;

  Image() = default;
  Image(int w, int h, int c) : width(w), height(h), channels(c), pixels(size_t(w) * size_t(h) * size_t(c)) {}
  size_t plane_size() const { return size_t(width) * size_t(height); }
  float* plane(int channel) { return pixels.data() + size_t(channel) * plane_size(); }
  const float* plane(int channel) const { return pixels.data() + size_t(channel) * plane_size(); }
  float& at(int channel, int x, int y) { return plane(channel)[size_t(y) * size_t(width) + size_t(x)]; }
  float at(int channel, int x, int y) const { return plane(channel)[size_t(y) * size_t(width) + size_t(x)]; }
};

/// The score of each metric, by its name, that noise of the reference's own size makes (metrics/floor.h);
/// empty where nobody knows it.
using ReferenceFloor = std::map<std::string, double>;

/// What was wrong with the samples of a frame, and what was done about it.
struct Faults {
  int64_t negative = 0;    // radiance channels below 0, set to 0
  int64_t not_finite = 0;  // samples with NaN or infinite radiance or alpha, masked out as if not drawn
  int64_t guides = 0;  // guides of other samples that are NaN or infinite, set to what a ray that escaped has
  int64_t clamped = 0;  // radiance channels beyond half's range, set to 65504 when a file was written
  int64_t parts = 0;    // colours of light parts that are NaN or infinite, in samples that count: set to 0
  bool any() const { return negative + not_finite + guides + clamped + parts > 0; }
};

/// Where a picture lies in a larger one that it was cut from or overscans: OpenEXR's data and display window,
/// in pixels, +y down.
struct Windows {
  int x = 0, y = 0;  // the upper left pixel of the data window, which is as large as the picture
  int display_left = 0, display_top = 0, display_right = -1,
      display_bottom = -1;  // inclusive; as it stands here: the data window
  bool operator==(const Windows& other) const {
    return x == other.x && y == other.y && display_left == other.display_left &&
           display_top == other.display_top && display_right == other.display_right &&
           display_bottom == other.display_bottom;
  }
  bool has_display() const { return display_right >= display_left; }
};

/// Where a frame came from; kept as attributes of the file. Empty or 0 where not known.
struct FrameInfo {
  std::string generator;  // program that rendered it
  std::string scene;      // what the picture shows, for people ("indoor, defocus")
  uint64_t seed = 0;
  int64_t frame = 0;      // index in its recipe
  float depth_scale = 0;  // median finite depth in scene units; 1 when every ray escaped
  std::string camera;     // parameters of the camera, for people
  int64_t clamped = 0;    // Faults::clamped when the file was written
  Windows windows;
  std::optional<Matrix4> world_to_camera, world_to_ndc;  // at shutter open, frame/camera_matrices.h
  bool cut = false;  // of a sequence: the camera was elsewhere in the frame before; flow is kNoFlow
};

/// Memory for so many values, all bits 0, which std::free takes back. Throws std::bad_alloc.
void* zero_pages(size_t count, size_t size);

/// Zeros from the system, in large pages where it can: a gigabyte in pages of 4 kB takes longer to get than
/// to decode. Memory that nobody writes to is not even taken. So values that are made without a word are left
/// as they lie: a vector with this allocator may shrink but must not grow again.
template <class T>
struct ZeroPages {
  using value_type = T;
  ZeroPages() = default;
  template <class U>
  ZeroPages(const ZeroPages<U>& /*other*/) noexcept {}
  T* allocate(size_t count) { return static_cast<T*>(zero_pages(count, sizeof(T))); }
  void deallocate(T* memory, size_t /*count*/) noexcept { std::free(memory); }
  template <class U>
  void construct(U* /*place*/) noexcept {}
  template <class U, class... Values>
  void construct(U* place, Values&&... values) {
    ::new (static_cast<void*>(place)) U(std::forward<Values>(values)...);
  }
  bool operator==(const ZeroPages& /*other*/) const { return true; }
  bool operator!=(const ZeroPages& /*other*/) const { return false; }
};

/// Light that adds up with others to the radiance: what one lamp sends, or what diffuse surfaces reflect.
struct LightPart {
  std::string name;                              // of the layer in files
  std::vector<float, ZeroPages<float>> samples;  // [spp, 3, height, width], linear; may be negative
};

/// Samples as [spp, channels, height, width] in the units of schema.cpp, with a validity mask [spp, height,
/// width]: 1 for a sample that was drawn, 0 for one that is missing or was masked out (its channels are then
/// 0, and its alpha). Channels of features that the frame does not hold are 0. Features from kSampleChannels
/// on have planes only where the frame was made with kAllChannels: ask holds() first.
struct Frame {
  int width = 0, height = 0, spp = 0, channels = kSampleChannels;
  std::vector<std::string> features = mh20_feature_names();  // those it holds, in any order
  std::vector<float, ZeroPages<float>> samples;
  std::vector<uint8_t> valid;
  std::vector<float> alpha;  // [spp, height, width]: 1 opaque, its radiance is premultiplied; empty: none
  std::vector<LightPart> parts;
  FrameInfo info;

  Frame() = default;
  /// `c`: kSampleChannels or kAllChannels (frame_channels()).
  Frame(int w, int h, int s, int c = kSampleChannels)
      : width(w),
        height(h),
        spp(s),
        channels(c),
        samples(size_t(w) * size_t(h) * size_t(s) * size_t(c)),
        valid(size_t(w) * size_t(h) * size_t(s), 1) {}
  size_t plane_size() const { return size_t(width) * size_t(height); }
  /// The memory of what it holds; features that it does not hold take none.
  int64_t bytes() const {
    const int64_t held = channel_count(features) + 3 * int64_t(parts.size());
    return int64_t(valid.size()) * (1 + held * int64_t(sizeof(float))) +
           int64_t(alpha.size() * sizeof(float));
  }
  float* plane(int sample, int channel) {
    return samples.data() + (size_t(sample) * size_t(channels) + size_t(channel)) * plane_size();
  }
  const float* plane(int sample, int channel) const {
    return const_cast<Frame*>(this)->plane(sample, channel);
  }
  float* part_plane(size_t part, int sample, int channel) {
    return parts[part].samples.data() + (size_t(sample) * 3 + size_t(channel)) * plane_size();
  }
  const float* part_plane(size_t part, int sample, int channel) const {
    return const_cast<Frame*>(this)->part_plane(part, sample, channel);
  }
  LightPart& add_part(const std::string& name) {
    parts.push_back({name, std::vector<float, ZeroPages<float>>(size_t(spp) * 3 * plane_size())});
    return parts.back();
  }
  uint8_t* valid_plane(int sample) { return valid.data() + size_t(sample) * plane_size(); }
  const uint8_t* valid_plane(int sample) const { return valid.data() + size_t(sample) * plane_size(); }
  bool holds(const std::string& feature) const {
    return std::find(features.begin(), features.end(), feature) != features.end();
  }
};

/// Of a light part: means of such are finite.
constexpr float kLargestPart = 3e38F;

/// Masks samples whose radiance or alpha holds a NaN or an infinity. A guide that holds one is set to what a
/// ray that escaped has (depth kEscapedDepth, all others 0): it costs the guide, not the light. Sets negative
/// radiance and what its channels for filters say of it to 0, clamps guides to half's range, ids to [0,
/// kMostId], alpha to [0, 1] and sets the channels of masked samples to 0. A light part whose colour holds a
/// NaN or an infinity is 0 in that sample, which counts all the same; those beyond +-kLargestPart are set to
/// that. Every frame passes through here once, on its way in.
Faults sanitise(Frame& frame);

/// The same for `count` pixels of one sample from `first` on; adds to `faults`. Different pixels may be done
/// at once.
void sanitise(Frame& frame, int sample, size_t first, size_t count, Faults& faults);

/// Darkens radiance of a sample that is beyond half's range as fit_colours_in_half() does, and its parts with
/// it. Returns how many channels were beyond.
int64_t fit_in_half(Frame& frame, int sample);

/// Mean radiance of the valid samples, [3, H, W], accumulated in double; 0 where a pixel has none.
Image mean_radiance(const Frame& frame);

/// Mean alpha of the valid samples, [1, H, W]; 0 where a pixel has none. The frame must have alpha.
Image mean_alpha(const Frame& frame);

/// Median over the depths of valid samples below kEscapedDepth, the upper one of an even number; 1 when there
/// is none, or no depth. NaN counts as escaped.
float median_depth(const Frame& frame, int threads = 1);

}  // namespace ld
