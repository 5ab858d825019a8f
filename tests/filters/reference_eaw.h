// Dammertz et al. 2010 written from the equations, in double, one pixel and one tap after the other.
#pragma once

#include <vector>

#include "filters/kernels/surfaces.h"
#include "filters/settings.h"

namespace ld {

/// [plane][y][x].
using DoublePlanes = std::vector<std::vector<std::vector<double>>>;
DoublePlanes to_double(const RowPlanes& planes);

/// The 1-D kernel at distance 0, 1, 2.
std::vector<double> reference_taps(const std::string& kernel);

DoublePlanes reference_eaw_level(const Surfaces& surfaces, const DoublePlanes& in, int level,
                                 const EawSettings& settings);
DoublePlanes reference_eaw(const Surfaces& surfaces, const RowPlanes& signals, const EawSettings& settings);

/// Largest |a - b| / (|b| + floor).
double largest_difference(const RowPlanes& a, const DoublePlanes& b, double floor);

}  // namespace ld
