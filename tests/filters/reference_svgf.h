// Schied et al. 2017 written from the equations, in double, one pixel and one tap after the other; and, for
// comparison, how one published implementation differs from them.
#pragma once

#include <optional>

#include "filters/kernels/surfaces.h"
#include "filters/settings.h"
#include "reference_eaw.h"

namespace ld {

/// Planes of light have [r, g, b] a signal, variances one a signal, moments m1 and m2 a signal.
struct ReferenceSvgfState {
  std::optional<Surfaces> surfaces;
  DoublePlanes light, moments, length;
};

struct ReferenceSvgf {
  SvgfSettings settings;
  /// The variance divided by sum w^2 instead of (sum w)^2: it then never falls.
  bool variance_slip = false;

  /// The filtered light of one frame; moves the state on.
  DoublePlanes operator()(const Surfaces& surfaces, const RowPlanes& signals,
                          ReferenceSvgfState& state) const;

  DoublePlanes slopes(const Surfaces& surfaces) const;
  void accumulate(const Surfaces& surfaces, const DoublePlanes& slopes, const DoublePlanes& signals,
                  const ReferenceSvgfState& previous, DoublePlanes& light, DoublePlanes& moments,
                  DoublePlanes& length) const;
  void estimate_variance(const Surfaces& surfaces, const DoublePlanes& slopes, const DoublePlanes& moments,
                         const DoublePlanes& length, DoublePlanes& light, DoublePlanes& variance) const;
  void level(const Surfaces& surfaces, const DoublePlanes& slopes, int k, DoublePlanes& light,
             DoublePlanes& variance) const;

 private:
  double surface_weight(const Surfaces& surfaces, const DoublePlanes& slopes, int x, int y, int u,
                        int v) const;
};

}  // namespace ld
