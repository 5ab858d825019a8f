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

/// state.picture becomes the mean of `now`, three planes, with the history (kernels/antialias_row.h). The new
/// frame's share is `alpha`, more for the first ones. What `now` and `spare` hold afterwards is anything.
/// Without flow the picture is `now`.
void antialias(const Surfaces& surfaces, RowPlanes& now, AntialiasState& state, RowPlanes& spare,
               double alpha, double deviations, int threads);

}  // namespace ld
