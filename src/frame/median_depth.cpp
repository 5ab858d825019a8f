// The scale that encodes depths (schema.cpp).
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>

#include "core/threads.h"
#include "frame/sample_arrays.h"

namespace ld {
namespace {

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
