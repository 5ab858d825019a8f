// A frame and its reference as training reads them: half floats in square tiles, so that a crop touches few
// pages of a memory-mapped file. What a cache file holds (dataset/frame_cache.h), and the same in memory
// where there is none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "frame/frame_pair.h"

namespace ld {

/// Side of the tiles, pixels. At 8 spp and 20 channels a tile is 80 kB; a crop of 128x128 pixels touches at
/// most 81 of them where 64 would do.
constexpr int kTileSide = 16;
constexpr int kTilePixels = kTileSide * kTileSide;

/// Where the plane of one sample or channel begins in the planes of a tile.
constexpr std::ptrdiff_t tile_plane(int number) {
  return std::ptrdiff_t{kTilePixels} * number;
}

/// A rectangle of whole tiles: columns [x0, x1), rows [y0, y1).
struct TileRange {
  int x0, y0, x1, y1;
};

/// Samples of a frame by their numbers, ascending; empty: all of them.
using SampleList = std::vector<int>;

struct PackedFrame {
  int width = 0, height = 0, spp = 0;
  std::vector<std::string> features;  // held, in the order of the schema; radiance is the first
  float depth_scale = 1;

  // Tile after tile, row by row; pixels outside of the picture are 0.
  const uint16_t* samples = nullptr;   // [tiles, spp, channels, kTileSide, kTileSide] bits of half floats
  const uint8_t* valid = nullptr;      // [tiles, spp, kTileSide, kTileSide]; the channels of 0s are 0
  const float* reference = nullptr;    // [tiles, 3, kTileSide, kTileSide] linear
  const float* difficulty = nullptr;   // [tiles], see pack()
  const int64_t* checksums = nullptr;  // [tiles, 2 spp + 1] of each sample, each mask and the reference
  std::shared_ptr<const void> memory;  // keeps all these alive

  int channels() const { return channel_count(features); }
  int tiles_x() const { return (width + kTileSide - 1) / kTileSide; }
  int tiles_y() const { return (height + kTileSide - 1) / kTileSide; }
  size_t tiles() const { return static_cast<size_t>(tiles_x()) * static_cast<size_t>(tiles_y()); }
  size_t tile_samples() const { return static_cast<size_t>(spp * channels()) * kTilePixels; }
  size_t tile_valid() const { return static_cast<size_t>(spp) * kTilePixels; }
  static constexpr size_t kTileReference = size_t{3} * kTilePixels;
  size_t tile_checksums() const { return 2 * static_cast<size_t>(spp) + 1; }

  /// Of all that the pointers point to.
  size_t bytes() const {
    return tiles() * (2 * tile_samples() + tile_valid() + 4 * kTileReference + sizeof(float) +
                      sizeof(int64_t) * tile_checksums());
  }

  /// The tiles that a rectangle of pixels touches.
  static TileRange tiles_of(int x, int y, int rectangle_width, int rectangle_height) {
    return {x / kTileSide, y / kTileSide, (x + rectangle_width + kTileSide - 1) / kTileSide,
            (y + rectangle_height + kTileSide - 1) / kTileSide};
  }

  /// The list with `all` spelt out. Throws Error for a sample that the frame does not have.
  SampleList chosen(const SampleList& which) const;

  /// Whether these samples of these tiles, and the reference, have their checksums; reads nothing else.
  bool intact(const TileRange& range, const SampleList& which = {}) const;
};

/// Packs the named features, radiance always, of a sanitised frame, in memory. The difficulty of a tile is
/// the SMAPE ([MH20] eq. 9) of the samples' mean against the reference, over its pixels that have samples:
/// how far the tile is from being denoised. Where there is no reference, it is that of the mean of every
/// other sample against the mean of the rest, and the mean of all stands in the reference's place.
PackedFrame pack(const FramePair& pair, const std::vector<std::string>& features);

/// The named features and radiance, each once, in the order of the schema. Throws UsageError for an unknown
/// one.
std::vector<std::string> packed_features(const std::vector<std::string>& features);

}  // namespace ld
