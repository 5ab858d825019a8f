// Temporal antialiasing of filtered pictures (Karis 2014, "High Quality Temporal Supersampling"), with which
// Schied et al. 2017 end. A pixel of few samples shows one of the surfaces at an edge, another one in the
// next frame; no filter of light mends that.
#pragma once

#include "filters/kernels/surfaces.h"

namespace ld {

/// The picture that the next frame starts from, and how many frames it is the mean of.
struct AntialiasState {
  RowPlanes picture;
  int64_t frames = 0;
};

/// `now`, three planes, goes in and comes back as its mean with the history (kernels/antialias_row.h). The
/// new frame's share is `alpha`, more for the first ones. `spare` is memory of the same size. Without flow
/// nothing changes.
void antialias(const Surfaces& surfaces, RowPlanes& now, AntialiasState& state, RowPlanes& spare,
               double alpha, double deviations, int threads);

}  // namespace ld
