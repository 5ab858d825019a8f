// Samples in somebody else's memory, read where they lie.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frame/frame.h"

namespace ld {

/// A number of sample s, channel c and pixel (x, y) lies at data[s * sample + c * channel + y * row + x *
/// pixel].
struct StridedArray {
  const float* data = nullptr;
  ptrdiff_t sample = 0, channel = 0, row = 0, pixel = 0;
};

/// `count` pixels of one sample, from (x, y) on to the right.
struct SamplePlace {
  int sample = 0, y = 0, x = 0, count = 0;
};

/// What a Frame holds, as it comes: nobody has sanitised it.
struct SampleArrays {
  struct OfFeature {
    const Feature* feature;
    StridedArray array;
  };
  int width = 0, height = 0, spp = 0;
  std::vector<OfFeature> features;
  std::vector<StridedArray> parts;  // of the light
  std::optional<StridedArray> alpha;
  const uint8_t* valid = nullptr;  // [spp, height, width], 0 for samples that do not count; null: all do
  float depth_scale = 0;           // FrameInfo::depth_scale; 0: the median of the depths

  /// A frame of `pixels` x `rows` x `samples` for copies of these.
  Frame make_frame(int pixels, int rows = 1, int samples = 1) const;

  /// Copies and sanitises to sample `to_sample` of such a frame, from its pixel `first` on.
  void copy(const SamplePlace& place, Frame& to, int to_sample = 0, size_t first = 0) const;

  /// Whether a sample is left when all have been sanitised.
  bool any_valid() const;
};

/// median_depth() of a frame of them (frame/frame.h), for the samples that `valid` [spp, height, width] says
/// are valid.
float median_depth(const SampleArrays& arrays, const uint8_t* valid, int threads);

}  // namespace ld
