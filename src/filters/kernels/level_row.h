// What the kernels of the à-trous levels share: where the taps of a row lie.
#pragma once

#include <array>
#include <cstdint>

namespace ld {

/// Tap q = p + (dx, dy) of each pixel p of a row: its surface is `surfaces[x]` for the pixel at x, its light
/// `in[x]`; h is the kernel's. Of the 24 taps there are five distances from p, which `distance` numbers.
struct LevelTap {
  const float *surfaces = nullptr, *in = nullptr;
  float h = 0, dx = 0, dy = 0;
  int distance = 0;
};
constexpr int kTapDistances = 5;

/// Pixels [first, end) of one row of one level. Planes of one row lie `pitch` floats apart; before and behind
/// each row are margins (filters/kernels/row_planes.h), and whole vectors of pixels are written.
struct LevelRow {
  int64_t width = 0, pitch = 0, first = 0, end = 0;
  const float *surfaces = nullptr, *in = nullptr;  // of the row itself
  float* out = nullptr;
  // The lowest taps of the row that is filtered next, fetched meanwhile: a row of many planes is too short
  // for the processor to see that it goes on. Null outside.
  const float *next_surfaces = nullptr, *next_in = nullptr;
  int in_planes = 0;
  float h_centre = 0;
  int count = 0;
  std::array<LevelTap, 24> taps{};               // inside the picture, row by row, without the centre
  std::array<float, kTapDistances> distances{};  // in pixels
};

}  // namespace ld
