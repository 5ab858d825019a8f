#include "dataset/packed_frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/checksum.h"
#include "core/error.h"
#include "frame/half_rows.h"
#include "metrics/smape.h"

namespace ld {
namespace {

struct Buffers {
  std::vector<uint16_t> samples;
  std::vector<uint8_t> valid;
  std::vector<float> reference, difficulty;
  std::vector<int64_t> checksums;
};

/// Of the `index`th run of `count` values.
template <class Value>
int64_t checksum_of(const Value* data, size_t index, size_t count) {
  return static_cast<int64_t>(checksum(data + index * count, count * sizeof(Value)));
}

int64_t sample_checksum(const PackedFrame& frame, size_t sample_of_tile) {
  return checksum_of(frame.samples, sample_of_tile, static_cast<size_t>(frame.channels()) * kTilePixels);
}

int64_t mask_checksum(const PackedFrame& frame, size_t sample_of_tile) {
  return checksum_of(frame.valid, sample_of_tile, kTilePixels);
}

int64_t reference_checksum(const PackedFrame& frame, size_t tile) {
  return checksum_of(frame.reference, tile, PackedFrame::kTileReference);
}

/// Copies the tile at (x0, y0) of a picture into kTileSide x kTileSide values, 0 outside of the picture.
template <class Value>
void cut_tile(const Value* plane, int width, int height, int x0, int y0, Value* tile) {
  const int columns = std::min(kTileSide, width - x0), rows = std::min(kTileSide, height - y0);
  std::fill_n(tile, kTilePixels, Value{0});
  for (int y = 0; y < rows; ++y)
    std::copy_n(plane + static_cast<size_t>(y0 + y) * static_cast<size_t>(width) + static_cast<size_t>(x0),
                columns, tile + y * kTileSide);
}

/// The samples of a tile: radiance is in the first three of the packed channels.
struct TileSamples {
  const float* radiance;
  const uint8_t* valid;
  int spp;
  size_t pitch;  // floats from one sample to the next

  /// The mean radiance of the valid ones of the samples first, first + step, ...; 0 where there is none.
  void mean(int first, int step, float* result) const {
    std::array<int, kTilePixels> drawn{};
    std::fill_n(result, PackedFrame::kTileReference, 0.0F);
    for (int s = first; s < spp; s += step)
      for (size_t p = 0; p < kTilePixels; ++p) {
        if (valid[tile_plane(s) + static_cast<std::ptrdiff_t>(p)] == 0) continue;
        ++drawn[p];
        for (size_t c = 0; c < 3; ++c)
          result[c * kTilePixels + p] += radiance[static_cast<size_t>(s) * pitch + c * kTilePixels + p];
      }
    for (size_t c = 0; c < 3; ++c)
      for (size_t p = 0; p < kTilePixels; ++p)
        if (drawn[p] > 0) result[c * kTilePixels + p] /= static_cast<float>(drawn[p]);
  }
};

/// Of two pictures of a tile, over the pixels that have samples.
float smape_of_tile(const float* a, const float* b, const uint8_t* valid, int spp) {
  constexpr auto kEpsilon = static_cast<float>(kSmapeEpsilon);
  double sum = 0;
  int count = 0;
  for (size_t p = 0; p < kTilePixels; ++p) {
    bool drawn = false;
    for (int s = 0; s < spp && !drawn; ++s)
      drawn = valid[tile_plane(s) + static_cast<std::ptrdiff_t>(p)] != 0;
    if (!drawn) continue;
    ++count;
    for (size_t i = p; i < PackedFrame::kTileReference; i += kTilePixels)
      sum += std::fabs(a[i] - b[i]) / (std::fabs(a[i]) + std::fabs(b[i]) + kEpsilon);
  }
  return count == 0 ? 0.0F : static_cast<float>(sum / (3 * count));
}

}  // namespace

SampleList PackedFrame::chosen(const SampleList& which) const {
  SampleList list = which;
  if (list.empty()) {
    list.resize(static_cast<size_t>(spp));
    std::iota(list.begin(), list.end(), 0);
  }
  for (const int s : list)
    if (s < 0 || s >= spp) fail("a packed frame of {} samples has no sample {}", spp, s);
  return list;
}

bool PackedFrame::intact(const TileRange& range, const SampleList& which) const {
  const SampleList list = chosen(which);
  const auto all = static_cast<size_t>(spp);
  for (int y = range.y0; y < range.y1; ++y)
    for (int x = range.x0; x < range.x1; ++x) {
      const size_t tile = static_cast<size_t>(y) * static_cast<size_t>(tiles_x()) + static_cast<size_t>(x);
      const int64_t* stored = checksums + tile * tile_checksums();
      for (const int sample : list) {
        const auto s = static_cast<size_t>(sample);
        if (sample_checksum(*this, tile * all + s) != stored[s] ||
            mask_checksum(*this, tile * all + s) != stored[all + s])
          return false;
      }
      if (reference_checksum(*this, tile) != stored[2 * all]) return false;
    }
  return true;
}

std::vector<std::string> packed_features(const std::vector<std::string>& features) {
  for (const std::string& name : features) find_feature(name);
  std::vector<std::string> packed;
  for (const Feature& feature : feature_schema())
    if (feature.name == "radiance" ||
        std::find(features.begin(), features.end(), feature.name) != features.end())
      packed.push_back(feature.name);
  return packed;
}

PackedFrame pack(const FramePair& pair, const std::vector<std::string>& features) {
  const Frame& frame = pair.frame;
  PackedFrame packed;
  packed.width = frame.width;
  packed.height = frame.height;
  packed.spp = frame.spp;
  packed.features = packed_features(features);
  packed.depth_scale = frame.info.depth_scale;
  std::vector<int> planes;  // where the packed channels are in the frame
  for (const std::string& name : packed.features)
    for (int c = 0; c < find_feature(name).channels; ++c) planes.push_back(find_feature(name).offset + c);

  const auto buffers = std::make_shared<Buffers>();
  buffers->samples.resize(packed.tiles() * packed.tile_samples());
  buffers->valid.resize(packed.tiles() * packed.tile_valid());
  buffers->reference.resize(packed.tiles() * PackedFrame::kTileReference);
  const size_t sample_pitch = planes.size() * kTilePixels;
  std::vector<float> cut(packed.tile_samples());
  std::array<float, PackedFrame::kTileReference> mean{}, other{};
  const bool has_reference = pair.reference.image.width > 0;
  for (size_t tile = 0; tile < packed.tiles(); ++tile) {
    const int x0 = static_cast<int>(tile % static_cast<size_t>(packed.tiles_x())) * kTileSide;
    const int y0 = static_cast<int>(tile / static_cast<size_t>(packed.tiles_x())) * kTileSide;
    const auto cut_plane = [&](const auto* plane, auto* out) {
      cut_tile(plane, frame.width, frame.height, x0, y0, out);
    };
    uint8_t* valid = buffers->valid.data() + tile * packed.tile_valid();
    float* reference = buffers->reference.data() + tile * PackedFrame::kTileReference;
    for (int s = 0; s < frame.spp; ++s) {
      uint8_t* mask = valid + tile_plane(s);
      cut_plane(frame.valid_plane(s), mask);
      float* channel = cut.data() + static_cast<size_t>(s) * sample_pitch;
      for (const int plane : planes) {
        cut_plane(frame.plane(s, plane), channel);
        for (size_t p = 0; p < kTilePixels; ++p) channel[p] = mask[p] != 0 ? channel[p] : 0.0F;
        channel += kTilePixels;
      }
    }
    const TileSamples samples = {cut.data(), valid, frame.spp, sample_pitch};
    if (has_reference) {
      for (int c = 0; c < 3; ++c) cut_plane(pair.reference.image.plane(c), reference + tile_plane(c));
      samples.mean(0, 1, mean.data());
      buffers->difficulty.push_back(smape_of_tile(mean.data(), reference, valid, frame.spp));
    } else {
      samples.mean(0, 1, reference);
      samples.mean(0, 2, mean.data());
      samples.mean(1, 2, other.data());
      buffers->difficulty.push_back(smape_of_tile(mean.data(), other.data(), valid, frame.spp));
    }
    float_to_half(cut.data(), buffers->samples.data() + tile * packed.tile_samples(), cut.size());
  }
  packed.samples = buffers->samples.data();
  packed.valid = buffers->valid.data();
  packed.reference = buffers->reference.data();
  packed.difficulty = buffers->difficulty.data();
  for (size_t tile = 0; tile < packed.tiles(); ++tile) {
    const auto all = static_cast<size_t>(packed.spp);
    for (size_t s = 0; s < all; ++s) buffers->checksums.push_back(sample_checksum(packed, tile * all + s));
    for (size_t s = 0; s < all; ++s) buffers->checksums.push_back(mask_checksum(packed, tile * all + s));
    buffers->checksums.push_back(reference_checksum(packed, tile));
  }
  packed.checksums = buffers->checksums.data();
  packed.memory = buffers;
  return packed;
}

}  // namespace ld
