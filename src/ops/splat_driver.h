// Runs the splat of a batch over all threads: strips of source rows, each stretch of logits made by the
// caller, then the rows of destinations. The strips do not depend on the thread count, so neither do the
// bits.
#pragma once

#include <ATen/Parallel.h>

#include <memory>
#include <vector>

#include "ops/kernels/splat.h"
#include "ops/kernels/tile_network.h"
#include "ops/pictures.h"

namespace ld {

constexpr int64_t kStripRows = 32;

/// Values and their weights, contiguous: log_n [B, N, H, W], values [B, N, C, H, W].
struct SplatInput {
  Pictures<float> log_n, values;
};

/// log n and values of a stretch.
inline void stage_values(const FilterShape& shape, const SplatInput& input, int64_t b, const Stretch& at,
                         SplatSourcesRow& sources) {
  const int64_t offset = at.y * shape.width + at.x;
  stage({input.log_n[b] + offset, shape.layers, shape.plane()}, at.count, sources.log_n.row(0),
        sources.log_n.pitch());
  stage({input.values[b] + offset, shape.layers * shape.channels, shape.plane()}, at.count,
        sources.values.row(0), sources.values.pitch());
}

/// Calls body(stretch) for the stretches of rows [first, last), column by column: the strip's rows that a
/// stretch reaches stay in the cache for the next row's.
template <class Body>
void for_each_stretch(const FilterShape& shape, int64_t pixels, int64_t first, int64_t last,
                      const Body& body) {
  for (int64_t x = 0; x < shape.width; x += pixels)
    for (int64_t y = first; y < last; ++y) body(Stretch{y, x, std::min(pixels, shape.width - x)});
}

/// `make_stage()` gives each thread a function (picture, stretch, sources) that writes the stretch's logits;
/// result(b) says where picture b's results go.
template <class MakeStage, class Result>
void run_splat(const FilterShape& shape, bool joint, int64_t batch, const SplatInput& input,
               const MakeStage& make_stage, const Result& result) {
  const int64_t strips = (shape.height + kStripRows - 1) / kStripRows;
  const int64_t pixels = stretch_pixels(shape.layers * shape.taps(), shape.width);
  std::vector<std::unique_ptr<SplatStrip>> memory(size_t(batch * strips));
  at::parallel_for(0, batch * strips, 1, [&](int64_t begin, int64_t end) {
    SplatSourcesRow sources(shape, pixels);
    auto stage_logits = make_stage();
    for (int64_t i = begin; i < end; ++i) {
      const int64_t b = i / strips, first = i % strips * kStripRows,
                    last = std::min(first + kStripRows, shape.height);
      auto strip = std::make_unique<SplatStrip>(shape, joint, first, last);
      for_each_stretch(shape, pixels, first, last, [&](const Stretch& at) {
        stage_logits(b, at, sources);
        stage_values(shape, input, b, at, sources);
        splat_exponents(shape, sources, at.count);
        splat_stretch(shape, sources, at, *strip);
      });
      memory[size_t(i)] = std::move(strip);
    }
  });
  at::parallel_for(0, batch * shape.height, 1, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      std::vector<SplatStrip*> of_picture;
      for (int64_t s = 0; s < strips; ++s)
        of_picture.push_back(memory[size_t(i / shape.height * strips + s)].get());
      const int64_t y = i % shape.height;
      merge_row(shape, joint, of_picture, y, result(i / shape.height).at(y * shape.width));
    }
  });
}

}  // namespace ld
