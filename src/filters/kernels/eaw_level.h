// One row of one level of Dammertz et al. 2010.
#pragma once

#include "filters/kernels/level_row.h"

namespace ld {

/// 1 / sigma of each weight at this level; 0 switches the weight off.
struct EawPrecision {
  float light = 0, normal = 0, place = 0;
};

/// out(p) = sum_q h w in(q) / sum_q h w over the 5x5 taps q with the surface of p,
///   w = exp(-|d|^2 / sigma_light - |n_p - n_q|^2 / sigma_normal - |X_p - X_q|^2 / sigma_place),
/// for `signals` (1 or 2) of three planes each, every one with its own d: the difference of its colours or,
/// with `luminance`, of their luminances. X is the position or, with `depth`, the depth. Where no surface is,
/// out = in.
void eaw_level_row(const LevelRow& row, const EawPrecision& precision, int signals, bool luminance,
                   bool depth);

}  // namespace ld
