// Where a network's samples lie: in a frame, or in somebody else's arrays, of which no copy is made.
#pragma once

#include <algorithm>
#include <vector>

#include "frame/sample_arrays.h"
#include "graph/extent.h"
#include "graph/graph.h"
#include "runtime/row_window.h"

namespace ld {

class LightRanges;

/// One sample of some pixels in a row, sanitised: that of `frame`, from its pixel `first` on.
struct SampleStretch {
  const Frame* frame = nullptr;
  int sample = 0;
  size_t first = 0;

  const float* plane(int channel) const { return frame->plane(sample, channel) + first; }
  const float* part(size_t part, int c) const { return frame->part_plane(part, sample, c) + first; }
  const float* alpha() const { return frame->alpha.data() + size_t(sample) * frame->plane_size() + first; }
  const uint8_t* valid() const { return frame->valid_plane(sample) + first; }
};

/// What a graph has to know of the whole picture's light before it runs.
struct Light {
  double exposure = 1;  // where Graph::exposed says so (models/exposure.h)
  // Of radiance, and of parts of it, in filters, whose sums could overflow (ops/finite_sources.h). Apart, so
  // that no part changes the picture.
  float value_scale = 1, part_scale = 1;
};

class SampleSource {
 public:
  virtual ~SampleSource() = default;
  virtual graph::PictureExtent extent() const = 0;
  virtual graph::LightParts parts() const = 0;  // that there are
  /// In each of the threads of `tile.thread` by itself; good until the next call.
  virtual SampleStretch read(int sample, const PixelTile& tile) = 0;

  float depth_scale = 0;  // FrameInfo::depth_scale
  Light light;
};

/// Frames have been sanitised and have a depth scale. Neither source depends on the number of threads.
/// `ranges` receives the rows of the light, where it is given.
class FrameSource : public SampleSource {
 public:
  FrameSource(const Frame& frame, const graph::Graph& graph, int threads, LightRanges* ranges);
  graph::PictureExtent extent() const override { return {frame_.spp, frame_.height, frame_.width}; }
  graph::LightParts parts() const override { return {int64_t(frame_.parts.size()), !frame_.alpha.empty()}; }
  SampleStretch read(int sample, const PixelTile& tile) override {
    return {&frame_, sample, size_t(tile.y * frame_.width + tile.x)};
  }

 private:
  const Frame& frame_;
};

/// Sanitises what it reads, in memory for a tile.
class ArraySource : public SampleSource {
 public:
  ArraySource(const SampleArrays& arrays, const graph::Graph& graph, int threads, LightRanges* ranges);
  graph::PictureExtent extent() const override { return {arrays_.spp, arrays_.height, arrays_.width}; }
  graph::LightParts parts() const override {
    return {int64_t(arrays_.parts.size()), arrays_.alpha.has_value()};
  }
  SampleStretch read(int sample, const PixelTile& tile) override;

  /// What it keeps of the picture.
  static int64_t bytes(const SampleArrays& arrays) {
    return int64_t(arrays.spp) * arrays.height * arrays.width;
  }

 private:
  SampleArrays arrays_;
  std::vector<uint8_t> valid_;  // [spp, height, width], after sanitising
  std::vector<Frame> tiles_;    // of each thread
};

/// The exposure of models/exposure.h.
double frame_exposure(const Frame& frame, int threads);

/// Radiance times the exposure, at most half's largest number. In doubles: neither an exposure of 1e37 nor
/// radiance of 3e38 leaves their range.
inline void expose_row(const float* radiance, double exposure, float* out, int64_t count) {
  for (int64_t x = 0; x < count; ++x)
    out[x] = float(std::min(double(radiance[x]) * exposure, double(kHalfMax)));
}

}  // namespace ld
