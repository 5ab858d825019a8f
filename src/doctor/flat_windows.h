// Flat surfaces in a frame, found by their constant normals. On them the reciprocal of the depth along the
// view axis is an affine function of the pixel: a plane n.P = c seen through a pinhole at P = Z (x, y, -1)
// has 1 / Z = n.(x, y, -1) / c. So they show whether depth is along the axis or along the ray, and which way
// the normals should point in view space.
#pragma once

#include <array>
#include <vector>

#include "doctor/evidence.h"

namespace ld {

struct FlatWindow {
  /// Exponent k for which depth / |(x, y, -1)|^k is depth along the view axis: 0 when it is, 1 for distance
  /// along the ray. With its standard error.
  double exponent = 0, exponent_error = 0;
  /// The product, component by component, of the unit normal that the depth shows and the mean of the stored
  /// ones: the sum of the three is the cosine between them.
  std::array<double, 3> normal_products{};
  double normal_cosine() const { return normal_products[0] + normal_products[1] + normal_products[2]; }
};

/// Squares of an eighth of the picture's shorter side, all of whose samples hit something flat. Empty when
/// the frame lacks normals, depth or the field of view.
std::vector<FlatWindow> flat_windows(const Evidence& evidence);

}  // namespace ld
