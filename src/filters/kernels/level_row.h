// What the kernels of the à-trous levels share: where the taps of a row lie.
#pragma once

#include <array>
#include <cstdint>

namespace ld {

/// Tap q = p + (dx, dy) of each pixel p of a row: its surface is `surfaces[x]` for the pixel at x, its light
/// `in[x]`; h is the kernel's.
struct LevelTap {
  const float *surfaces = nullptr, *in = nullptr;
  float h = 0, dx = 0, dy = 0;
};

/// One row of one level. Planes of one row lie `pitch` floats apart; before and behind each row are margins
/// (filters/kernels/row_planes.h).
struct LevelRow {
  int64_t width = 0, pitch = 0;
  const float *surfaces = nullptr, *in = nullptr;  // of the row itself
  float* out = nullptr;
  float h_centre = 0;
  int count = 0;
  std::array<LevelTap, 24> taps{};  // inside the picture, row by row, without the centre
};

}  // namespace ld
