#include "runtime/sample_source.h"

#include <algorithm>

#include "models/log_luminance.h"
#include "ops/kernels/constants.h"
#include "runtime/light_ranges.h"
#include "runtime/parallel.h"
#include "runtime/step.h"

namespace ld {
namespace {

// Above this the sums of filters could overflow (ops/finite_sources.h): demodulated radiance is up to 50
// times as large.
constexpr float kLargestRadiance = 1e32f / 50;

/// Whether any is beyond kLargestRadiance; vectors take no early end.
bool any_large(const float* values, int64_t count) {
  int large = 0;
  for (int64_t x = 0; x < count; ++x)
    large |= int(values[x] > kLargestRadiance || values[x] < -kLargestRadiance);
  return large != 0;
}

/// The sums of a row's pixels, sample by sample.
class RowLight {
 public:
  explicit RowLight(int64_t width) : luminance_(size_t(width)), drawn_(size_t(width)) {}

  void add(const SampleStretch& row) {
    const float *red = row.plane(0), *green = row.plane(1), *blue = row.plane(2);
    const uint8_t* valid = row.valid();
    for (size_t x = 0; x < luminance_.size(); ++x) {
      if (valid[x] == 0) continue;
      luminance_[x] += luminance(double(red[x]), double(green[x]), double(blue[x]));
      ++drawn_[x];
    }
  }

  LogLuminance mean() const {
    LogLuminance sum;
    for (size_t x = 0; x < luminance_.size(); ++x)
      sum.add(luminance_[x] / double(std::max<int64_t>(drawn_[x], 1)));
    return sum;
  }

 private:
  std::vector<double> luminance_;
  std::vector<int64_t> drawn_;
};

struct WantedLight {
  bool exposure;
  graph::LightParts parts;
  LightRanges* ranges = nullptr;
};

/// read(sample, y, thread) gives a whole row of radiance, parts and mask, once.
template <class Read>
Light measure_light(const graph::PictureExtent& picture, const WantedLight& wanted, int threads,
                    const Read& read) {
  struct Row {
    LogLuminance luminance;
    bool large = false, large_part = false;
  };
  std::vector<Row> rows(size_t(picture.height));
  parallel_for(threads, picture.height, [&](int64_t y, int thread) {
    Row& row = rows[size_t(y)];
    RowLight light(wanted.exposure ? picture.width : 0);
    if (wanted.ranges != nullptr) wanted.ranges->begin_row(y);
    for (int s = 0; s < int(picture.samples); ++s) {
      const SampleStretch stretch = read(s, y, thread);
      for (int c = 0; c < 3; ++c) {
        row.large = any_large(stretch.plane(kRadianceOffset + c), picture.width) || row.large;
        for (size_t part = 0; part < size_t(wanted.parts.colours); ++part)
          row.large_part = any_large(stretch.part(part, c), picture.width) || row.large_part;
      }
      light.add(stretch);
      if (wanted.ranges != nullptr) wanted.ranges->add(y, stretch, wanted.parts);
    }
    if (wanted.ranges != nullptr) wanted.ranges->end_row(y);
    row.luminance = light.mean();
  });
  Light light;
  LogLuminance sum;
  for (const Row& row : rows) {
    sum.add(row.luminance);
    if (row.large) light.value_scale = float(kOverflowScale);
    if (row.large_part) light.part_scale = float(kOverflowScale);
  }
  if (wanted.exposure) light.exposure = sum.exposure();
  return light;
}

Light measure_light(const Frame& frame, const WantedLight& wanted, int threads) {
  return measure_light({frame.spp, frame.height, frame.width}, wanted, threads, [&](int s, int64_t y, int) {
    return SampleStretch{&frame, s, size_t(y * frame.width)};
  });
}

/// The graph's, as far as there are any: that all are there is checked later.
graph::LightParts parts_to_read(const graph::Graph& graph, const graph::LightParts& held) {
  return {std::min(graph.parts.colours, held.colours), graph.parts.alpha && held.alpha};
}

}  // namespace

FrameSource::FrameSource(const Frame& frame, const graph::Graph& graph, int threads, LightRanges* ranges)
    : frame_(frame) {
  depth_scale = frame.info.depth_scale;
  light = measure_light(frame, {graph.exposed, parts_to_read(graph, parts()), ranges}, threads);
}

ArraySource::ArraySource(const SampleArrays& arrays, const graph::Graph& graph, int threads,
                         LightRanges* ranges)
    : arrays_(arrays), valid_(size_t(bytes(arrays))) {
  SampleArrays alone = arrays;  // radiance, parts and alpha
  alone.features.erase(
      std::remove_if(alone.features.begin(), alone.features.end(),
                     [](const auto& held) { return held.feature->offset != kRadianceOffset; }),
      alone.features.end());
  std::vector<Frame> rows;
  for (int t = 0; t < threads; ++t) {
    rows.push_back(alone.make_frame(arrays.width));
    tiles_.push_back(arrays.make_frame(int(kTilePixels)));
  }
  const WantedLight wanted = {graph.exposed, parts_to_read(graph, parts()), ranges};
  light = measure_light(extent(), wanted, threads, [&](int s, int64_t y, int thread) {
    Frame& row = rows[size_t(thread)];
    alone.copy({s, int(y), 0, arrays.width}, row);
    std::copy(row.valid.begin(), row.valid.end(),
              valid_.begin() + (int64_t(s) * arrays.height + y) * arrays.width);
    return SampleStretch{&row, 0, 0};
  });
  arrays_.valid = valid_.data();
  depth_scale = arrays.depth_scale > 0 ? arrays.depth_scale : median_depth(arrays, valid_.data(), threads);
}

SampleStretch ArraySource::read(int sample, const PixelTile& tile) {
  Frame& to = tiles_[size_t(tile.thread)];
  arrays_.copy({sample, int(tile.y), int(tile.x), int(tile.count)}, to);
  return {&to, 0, 0};
}

double frame_exposure(const Frame& frame, int threads) {
  return measure_light(frame, {true, {}}, threads).exposure;
}

}  // namespace ld
