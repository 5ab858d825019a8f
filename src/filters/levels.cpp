#include "filters/levels.h"

#include <cmath>
#include <cstdlib>

namespace ld {

std::array<float, 3> a_trous_taps(const std::string& kernel) {
  if (kernel == "b3") return {6.0F / 16, 4.0F / 16, 1.0F / 16};
  const double near = std::exp(-0.5), far = std::exp(-2.0), total = 1 + 2 * near + 2 * far;
  return {float(1 / total), float(near / total), float(far / total)};
}

LevelRow level_row(const Surfaces& surfaces, const RowPlanes& in, RowPlanes& out, int64_t y, int64_t level,
                   const std::array<float, 3>& taps) {
  const int64_t stride = int64_t{1} << level;
  LevelRow row;
  row.width = in.width();
  row.pitch = in.pitch();
  row.surfaces = surfaces.of.row(y);
  row.in = in.row(y);
  row.out = out.row(y);
  row.h_centre = taps[0] * taps[0];
  for (int64_t j = -2; j <= 2; ++j) {
    const int64_t v = y + j * stride;
    if (v < 0 || v >= in.height()) continue;
    for (int64_t i = -2; i <= 2; ++i) {
      if (i == 0 && j == 0) continue;
      const float h = taps[size_t(std::abs(i))] * taps[size_t(std::abs(j))];
      row.taps[size_t(row.count++)] = {surfaces.of.row(v) + i * stride, in.row(v) + i * stride, h,
                                       float(i * stride), float(j * stride)};
    }
  }
  return row;
}

}  // namespace ld
