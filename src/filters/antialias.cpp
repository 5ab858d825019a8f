#include "filters/antialias.h"

#include <algorithm>
#include <utility>

#include "filters/kernels/antialias_row.h"
#include "runtime/denormals.h"
#include "runtime/parallel.h"

namespace ld {

void antialias(const Surfaces& surfaces, RowPlanes& now, AntialiasState& state, RowPlanes& spare,
               double alpha, double deviations, int threads) {
  const FlushedDenormals flushed(threads);
  const int width = now.width(), height = now.height();
  if (!surfaces.has_flow || !state.picture.is(width, height, 3)) state.frames = 0;
  resize(spare, width, height, 3);
  if (state.frames == 0) {
    std::swap(now, state.picture);
  } else {
    parallel_for(threads, height, [&](int64_t y, int) {
      AntialiasRow row;
      row.width = width;
      row.height = height;
      row.y = y;
      row.pitch = now.pitch();
      for (int64_t j = 0; j < 3; ++j) {
        const int64_t v = y + j - 1;
        if (v < 0 || v >= height) continue;
        row.depth[size_t(j)] = surfaces.of.row(v, kDepth);
        row.flow[size_t(j)] = surfaces.flow.row(v);
        row.now[size_t(j)] = now.row(v);
      }
      row.before = {state.picture.row(0), state.picture.row_pitch(), state.picture.pitch()};
      row.out = spare.row(y);
      row.share = float(std::max(alpha, 1 / double(state.frames + 1)));
      row.deviations = float(deviations);
      antialias_row(row);
    });
    std::swap(spare, state.picture);
  }
  ++state.frames;
}

}  // namespace ld
