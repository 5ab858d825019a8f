// Runs the gather of a batch over all threads, each stretch of logits made by the caller.
#pragma once

#include <ATen/Parallel.h>

#include "ops/kernels/gather.h"
#include "ops/kernels/tile_network.h"
#include "ops/pictures.h"

namespace ld {

/// One picture with margins, copied on all threads.
inline GatherSources gather_sources(const FilterShape& shape, const float* log_n, const float* values) {
  GatherSources sources(shape, shape.height);
  at::parallel_for(0, shape.height, 16, [&](int64_t begin, int64_t end) {
    for (int64_t y = begin; y < end; ++y)
      sources.fill_row(shape, {log_n + y * shape.width, shape.plane()},
                       {values + y * shape.width, shape.plane()}, y);
  });
  return sources;
}

/// `make_stage()` gives each thread a function (picture, stretch, logits) that writes the stretch's logits.
/// out [B, C, H, W]; totals [B, 2, H, W] may be null.
template <class MakeStage>
void run_gather(const FilterShape& shape, int64_t batch, const Pictures<float>& log_n,
                const Pictures<float>& values, const MakeStage& make_stage, const Pictures<float>& out,
                const Pictures<float>& totals) {
  const int64_t pixels = stretch_pixels(shape.taps(), shape.width);
  for (int64_t b = 0; b < batch; ++b) {
    const GatherSources sources = gather_sources(shape, log_n[b], values[b]);
    at::parallel_for(0, shape.height, 1, [&](int64_t begin, int64_t end) {
      GatherRow row(shape, pixels);
      auto stage_logits = make_stage();
      for (int64_t y = begin; y < end; ++y)
        for (int64_t x = 0; x < shape.width; x += pixels) {
          const Stretch at{y, x, std::min(pixels, shape.width - x)};
          stage_logits(b, at, row.logits);
          gather_stretch(shape, sources, at, row);
          const int64_t offset = y * shape.width + x;
          unstage(row.out.row(0), row.out.pitch(), shape.channels, at.count, out[b] + offset, shape.plane());
          if (totals[b] != nullptr)
            unstage(row.totals.row(0), row.totals.pitch(), 2, at.count, totals[b] + offset, shape.plane());
        }
    });
  }
}

}  // namespace ld
