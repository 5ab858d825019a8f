// The à-trous cascade of both filters: kernels and rows of one level.
#pragma once

#include <string>

#include "filters/kernels/level_row.h"
#include "filters/kernels/row_planes.h"
#include "filters/kernels/surfaces.h"
#include "runtime/parallel.h"

namespace ld {

/// The 1-D kernel at distance 0, 1, 2: "b3", the cubic B-spline (6, 4, 1) / 16, or "gauss", deviation 1.
std::array<float, 3> a_trous_taps(const std::string& kernel);

/// A stretch of a row: pixels [first, end).
struct LevelPiece {
  int64_t y = 0, first = 0, end = 0;
};

/// This stretch of level k (stride 2^k).
LevelRow level_row(const Surfaces& surfaces, const RowPlanes& in, RowPlanes& out, const LevelPiece& piece,
                   int64_t level, const std::array<float, 3>& taps);

/// body(piece) for all pixels, in an order in which taps are read from memory once and then from the nearest
/// cache: columns of kPieceWidth, each going down the rows a stride apart before the rows between them.
template <class Body>
void for_each_piece(int threads, int width, int height, int64_t level, const Body& body) {
  constexpr int64_t kPieceWidth = 256, kPieceRows = 64;  // five rows of two signals fit in half a megabyte
  const int64_t stride = int64_t{1} << level, longer = height % stride, rows = height / stride;
  const auto row_of = [&](int64_t i) {  // the i-th row in that order; the first `longer` runs have one more
    const int64_t split = longer * (rows + 1);
    return i < split ? i / (rows + 1) + i % (rows + 1) * stride
                     : longer + (i - split) / rows + (i - split) % rows * stride;
  };
  const int64_t across = (width + kPieceWidth - 1) / kPieceWidth,
                down = (height + kPieceRows - 1) / kPieceRows;
  parallel_for(threads, across * down, [&](int64_t part, int) {
    const int64_t first = part / down * kPieceWidth, begin = part % down * kPieceRows;
    for (int64_t i = begin; i < std::min<int64_t>(begin + kPieceRows, height); ++i)
      body(LevelPiece{row_of(i), first, std::min<int64_t>(first + kPieceWidth, width)});
  });
}

}  // namespace ld
