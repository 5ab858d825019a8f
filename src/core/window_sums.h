// Sums over the window around each pixel.
#pragma once

#include <vector>

namespace ld {

/// Of a plane of width * height values, row by row, the sums over the (2 radius + 1)^2 pixels around each
/// pixel, as far as they lie in the plane. Every window is summed anew: a running sum would keep the rounding
/// of bright pixels that it has left.
std::vector<double> window_sums(const std::vector<double>& plane, int width, int height, int radius);

}  // namespace ld
