#include "core/window_sums.h"

#include <algorithm>
#include <cstddef>

namespace ld {
namespace {

/// Along one line of `count` values that lie `step` apart.
void sum_line(const double* values, std::ptrdiff_t step, int count, int radius, double* sums) {
  for (int i = 0; i < count; ++i) {
    double sum = 0;
    for (int j = std::max(i - radius, 0); j <= std::min(i + radius, count - 1); ++j) sum += values[j * step];
    sums[i * step] = sum;
  }
}

}  // namespace

std::vector<double> window_sums(const std::vector<double>& plane, int width, int height, int radius) {
  std::vector<double> across(plane.size()), result(plane.size());
  for (int y = 0; y < height; ++y) {
    const size_t first = size_t(y) * size_t(width);
    sum_line(plane.data() + first, 1, width, radius, across.data() + first);
  }
  for (int x = 0; x < width; ++x) sum_line(across.data() + x, width, height, radius, result.data() + x);
  return result;
}

}  // namespace ld
