// Small pictures that the tests of the filters are made of.
#pragma once

#include <cstdint>

#include "filters/kernels/row_planes.h"
#include "filters/kernels/surfaces.h"

namespace ld {

/// A wall that faces the camera: one id, one normal, one depth, positions a `step` apart.
Surfaces flat_wall(int width, int height, float step = 0.0F);

/// Surfaces of several ids, slanted, with some pixels where nothing is; pure functions of the seed.
Surfaces busy_scene(int width, int height, uint64_t seed);

/// Standard normal numbers, three planes a signal; `exponential`: with deviation and mean 1, never negative.
RowPlanes noise(int width, int height, int planes, uint64_t seed, bool exponential = false);

/// planes[p](x, y) = function(p, x, y).
template <class Function>
void fill(RowPlanes& planes, const Function& function) {
  for (int p = 0; p < planes.planes(); ++p)
    for (int y = 0; y < planes.height(); ++y)
      for (int x = 0; x < planes.width(); ++x) planes.at(x, y, p) = function(p, x, y);
}

template <class Function>
RowPlanes filled(int width, int height, int planes, const Function& function) {
  RowPlanes out(width, height, planes);
  fill(out, function);
  return out;
}

/// The rectangle from (x, y) on.
RowPlanes cut(const RowPlanes& planes, int x, int y, int width, int height);
Surfaces cut(const Surfaces& surfaces, int x, int y, int width, int height);

/// Mean and variance over the pixels of a plane, `border` from the edge left out.
struct Spread {
  double mean = 0, variance = 0;
};
Spread spread(const RowPlanes& planes, int plane, int border = 0);

}  // namespace ld
