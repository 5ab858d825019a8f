#include "filters/levels.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace ld {

std::array<float, 3> a_trous_taps(const std::string& kernel) {
  if (kernel == "b3") return {6.0F / 16, 4.0F / 16, 1.0F / 16};
  const double near = std::exp(-0.5), far = std::exp(-2.0), total = 1 + 2 * near + 2 * far;
  return {float(1 / total), float(near / total), float(far / total)};
}

LevelRow level_row(const Surfaces& surfaces, const RowPlanes& in, RowPlanes& out, const LevelPiece& piece,
                   int64_t level, const std::array<float, 3>& taps) {
  const int64_t stride = int64_t{1} << level, y = piece.y;
  LevelRow row;
  row.width = in.width();
  row.pitch = in.pitch();
  row.first = piece.first;
  row.end = piece.end;
  row.surfaces = surfaces.of.row(y);
  row.in = in.row(y);
  row.out = out.row(y);
  if (y + 3 * stride < in.height()) {
    row.next_surfaces = surfaces.of.row(y + 3 * stride);
    row.next_in = in.row(y + 3 * stride);
  }
  row.in_planes = in.planes();
  row.h_centre = taps[0] * taps[0];
  constexpr std::array<int, kTapDistances> kSquares = {1, 2, 4, 5, 8};
  for (size_t k = 0; k < kSquares.size(); ++k)
    row.distances[k] = float(stride) * std::sqrt(float(kSquares[k]));
  for (int64_t j = -2; j <= 2; ++j) {
    const int64_t v = y + j * stride;
    if (v < 0 || v >= in.height()) continue;
    for (int64_t i = -2; i <= 2; ++i) {
      if (i == 0 && j == 0) continue;
      const float h = taps[size_t(std::abs(i))] * taps[size_t(std::abs(j))];
      const auto square = std::find(kSquares.begin(), kSquares.end(), int(i * i + j * j));
      row.taps[size_t(row.count++)] = {
          surfaces.of.row(v) + i * stride, in.row(v) + i * stride, h, float(i * stride), float(j * stride),
          int(square - kSquares.begin())};
    }
  }
  return row;
}

}  // namespace ld
