// Some rows of a value, as far as somebody still reads them.
#pragma once

#include <cstdint>

#include "ops/kernels/dense.h"

namespace ld {

/// Pixels [x, x + count) of row y, and which thread has them; x is a multiple of kPixelStep.
struct PixelTile {
  int64_t y, x, count;
  int thread;
};

/// Rows of `planes` channels: those of one row lie one behind the other, `pitch` floats apart, each aligned
/// to whole vectors and followed by zeros, which a convolution takes for what is beyond the border. The
/// newest `capacity` rows are there: row y lies where row y - capacity was. Without capacity, a tile of each
/// of so many threads is there instead.
struct RowWindow {
  float* memory = nullptr;
  int64_t planes = 0, width = 0, height = 0, pitch = 0, capacity = 0, threads = 0;

  RowWindow() = default;
  RowWindow(int64_t planes_in, int64_t width_in, int64_t height_in, int64_t capacity_in)
      : planes(planes_in),
        width(width_in),
        height(height_in),
        pitch(padded(width_in) + kPixelStep),
        capacity(capacity_in) {}
  static RowWindow of_tiles(int64_t planes, int64_t width, int64_t height, int threads, int64_t pixels) {
    RowWindow window(planes, width, height, 0);
    window.pitch = padded(pixels);
    window.threads = threads;
    return window;
  }

  /// Of the memory, with zeros before the first and behind the last plane.
  int64_t floats() const { return (capacity + threads) * planes * pitch + 2 * kPixelStep; }

  float* row(int64_t y, int64_t plane = 0) const {
    return memory + kPixelStep + (y % capacity * planes + plane) * pitch;
  }
  PlanarRow planar(int64_t y, int64_t plane = 0) const { return {row(y, plane), pitch}; }

  /// From the tile's first pixel on.
  PlanarTarget at(const PixelTile& tile, int64_t plane = 0) const {
    if (capacity == 0) return {memory + kPixelStep + (tile.thread * planes + plane) * pitch, pitch};
    return {row(tile.y, plane) + tile.x, pitch};
  }
};

}  // namespace ld
