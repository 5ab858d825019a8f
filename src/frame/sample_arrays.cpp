#include "frame/sample_arrays.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>

#include "core/threads.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "frame/sample_arrays.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// rgbrgb... of `count` pixels to three planes, `pitch` floats apart.
void split_colours(const float* colours, size_t count, size_t pitch, float* planes) {
  const hn::ScalableTag<float> d;
  using V = hn::Vec<decltype(d)>;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    V red, green, blue;
    hn::LoadInterleaved3(d, colours + 3 * i, red, green, blue);
    hn::StoreU(red, d, planes + i);
    hn::StoreU(green, d, planes + pitch + i);
    hn::StoreU(blue, d, planes + 2 * pitch + i);
  }
  for (; i < count; ++i)
    for (size_t c = 0; c < 3; ++c) planes[c * pitch + i] = colours[3 * i + c];
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(split_colours);

namespace {

/// Planes [channels], `pitch` floats apart.
void copy_planes(const float* from, const StridedArray& strides, int channels, size_t count, float* to,
                 size_t pitch) {
  if (channels == 3 && strides.channel == 1 && strides.pixel == 3)  // the rule
    return HWY_DYNAMIC_DISPATCH(split_colours)(from, count, pitch, to);
  for (int c = 0; c < channels; ++c, from += strides.channel, to += pitch)
    if (strides.pixel == 1)
      std::copy_n(from, count, to);
    else
      for (size_t x = 0; x < count; ++x) to[x] = from[static_cast<ptrdiff_t>(x) * strides.pixel];
}

/// Bits in the order of the values.
uint32_t ordered_bits(float value) {
  uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return (bits >> 31) != 0 ? ~bits : bits | 0x80000000U;
}

float value_of(uint32_t ordered) {
  const uint32_t bits = (ordered >> 31) != 0 ? ordered & 0x7fffffffU : ~ordered;
  float value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

using Histogram = std::vector<int64_t>;  // of 2^16

/// Depths of all samples and which of them count.
struct Depths {
  int width, height, spp;
  StridedArray array;    // one channel
  const uint8_t* valid;  // [spp, height, width]

  /// Of digit(ordered bits) over the depths that count; a digit below 0 does not.
  template <class Digit>
  Histogram histogram(int threads, const Digit& digit) const {
    const int64_t rows = int64_t{spp} * height,
                  pieces = std::clamp<int64_t>(rows * width >> 16, 1, std::min(threads, 64));
    std::vector<Histogram> parts(static_cast<size_t>(pieces), Histogram(1 << 16));
    parallel_for(pieces, threads, [&](int64_t part) {
      for (int64_t row = rows * part / pieces; row < rows * (part + 1) / pieces; ++row)
        add_row(row, digit, parts[static_cast<size_t>(part)]);
    });
    for (size_t part = 1; part < parts.size(); ++part)
      std::transform(parts[part].begin(), parts[part].end(), parts[0].begin(), parts[0].begin(),
                     std::plus<>());
    return parts[0];
  }

  template <class Digit>
  void add_row(int64_t row, const Digit& digit, Histogram& count) const {
    const float* from = array.data + row / height * array.sample + row % height * array.row;
    const uint8_t* drawn = valid + row * width;
    for (int x = 0; x < width; ++x) {
      const float depth = from[x * array.pixel];
      const int32_t place = digit(ordered_bits(depth));
      if (drawn[x] != 0 && depth < kEscapedDepth && depth >= std::numeric_limits<float>::lowest() &&
          place >= 0)
        ++count[static_cast<size_t>(place)];
    }
  }
};

/// The place that has the value of this rank, which becomes its rank within that place.
uint32_t place_of(const Histogram& count, int64_t& rank) {
  uint32_t place = 0;
  while (rank >= count[place]) rank -= count[place++];
  return place;
}

/// By the upper half of the bits, then by the lower: two passes over the depths, and no copy of them.
float median_of(const Depths& depths, int threads) {
  const Histogram upper =
      depths.histogram(threads, [](uint32_t bits) { return static_cast<int32_t>(bits >> 16); });
  const int64_t count = std::accumulate(upper.begin(), upper.end(), int64_t{0});
  if (count == 0) return 1;
  int64_t rank = count / 2;
  const uint32_t high = place_of(upper, rank);
  const Histogram lower = depths.histogram(threads, [high](uint32_t bits) {
    return bits >> 16 == high ? static_cast<int32_t>(bits & 0xffffU) : -1;
  });
  // A camera inside a surface sees depth 0; a scale of 0 would divide by zero.
  return std::max(value_of(high << 16 | place_of(lower, rank)), 1e-6F);
}

}  // namespace

Frame SampleArrays::make_frame(int pixels, int rows, int samples) const {
  std::vector<std::string> names;
  for (const OfFeature& held : features) names.push_back(held.feature->name);
  Frame frame(pixels, rows, samples, frame_channels(names));
  frame.features = std::move(names);
  for (size_t part = 0; part < parts.size(); ++part) frame.add_part("");
  if (alpha) frame.alpha.resize(frame.valid.size());
  return frame;
}

void SampleArrays::copy(const SamplePlace& place, Frame& to, int to_sample, size_t first) const {
  const auto count = static_cast<size_t>(place.count);
  const auto copy_array = [&](const StridedArray& array, int channels, float* plane) {
    const float* from =
        array.data + place.sample * array.sample + place.y * array.row + place.x * array.pixel;
    copy_planes(from, array, channels, count, plane + first, to.plane_size());
  };
  for (const OfFeature& held : features)
    copy_array(held.array, held.feature->channels, to.plane(to_sample, held.feature->offset));
  for (size_t part = 0; part < parts.size(); ++part)
    copy_array(parts[part], 3, to.part_plane(part, to_sample, 0));
  if (alpha) copy_array(*alpha, 1, to.alpha.data() + static_cast<size_t>(to_sample) * to.plane_size());
  uint8_t* const drawn = to.valid_plane(to_sample) + first;
  if (valid == nullptr) {
    std::fill_n(drawn, count, uint8_t{1});
  } else {
    const size_t row =
        static_cast<size_t>(place.sample) * static_cast<size_t>(height) + static_cast<size_t>(place.y);
    std::transform(valid + row * static_cast<size_t>(width) + place.x,
                   valid + row * static_cast<size_t>(width) + place.x + place.count, drawn,
                   [](uint8_t given) { return static_cast<uint8_t>(given != 0); });
  }
  Faults faults;
  sanitise(to, to_sample, first, count, faults);
}

bool SampleArrays::any_valid() const {
  Frame row = make_frame(width);
  for (int s = 0; s < spp; ++s)
    for (int y = 0; y < height; ++y) {
      copy({s, y, 0, width}, row);
      if (std::any_of(row.valid.begin(), row.valid.end(), [](uint8_t drawn) { return drawn != 0; }))
        return true;
    }
  return false;
}

float median_depth(const Frame& frame, int threads) {
  if (!frame.holds("depth")) return 1;
  const auto plane = static_cast<ptrdiff_t>(frame.plane_size());
  const StridedArray array = {frame.plane(0, kDepthOffset), frame.channels * plane, plane, frame.width, 1};
  return median_of({frame.width, frame.height, frame.spp, array, frame.valid.data()}, threads);
}

float median_depth(const SampleArrays& arrays, const uint8_t* valid, int threads) {
  for (const SampleArrays::OfFeature& held : arrays.features)
    if (held.feature->offset == kDepthOffset)
      return median_of({arrays.width, arrays.height, arrays.spp, held.array, valid}, threads);
  return 1;
}

}  // namespace ld
#endif
