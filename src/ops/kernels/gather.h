// Inner loops of ops/kernel_gather.h for one picture, float32, for every SIMD width (Highway).
#pragma once

#include <vector>

#include "ops/kernels/filter.h"

namespace ld {

/// What a picture gives, with margins: rows of log n (-inf outside of the picture) and of each channel, the
/// newest `capacity` of them.
class GatherSources {
 public:
  GatherSources(const FilterShape& shape, int64_t capacity);
  const float* row(int64_t y) const { return rows_.row(y % capacity_ * planes_); }
  int64_t pitch() const { return rows_.pitch(); }
  int64_t floats() const { return rows_.floats(); }
  /// Row y from log n and all channels there.
  void fill_row(const FilterShape& shape, PlanarRow log_n, PlanarRow values, int64_t y) {
    copy(shape, log_n, y, 0, 1);
    copy(shape, values, y, 1, shape.channels);
  }

 private:
  void copy(const FilterShape& shape, PlanarRow from, int64_t y, int64_t plane, int64_t count) {
    for (int64_t c = 0; c < count; ++c)
      std::copy_n(from.data + c * from.pitch, shape.width, rows_.row(y % capacity_ * planes_ + plane + c));
  }

  int64_t planes_, capacity_;
  StagedRows rows_;
};

/// A stretch: logits [taps], which become weights; `totals` the largest exponent and 1 / the sum of weights;
/// out [channels].
struct GatherRow {
  StagedRows logits, totals, out;
  GatherRow(const FilterShape& shape, int64_t pixels);
};
void gather_stretch(const FilterShape& shape, const GatherSources& sources, const Stretch& at,
                    GatherRow& row);

/// Sums towards the gradients of the values of rows [first, last) widened by the kernel.
class GatherStrip {
 public:
  GatherStrip(const FilterShape& shape, int64_t first, int64_t last);
  bool holds(int64_t y) const { return y >= begin_ && y < end_; }
  float* row(int64_t channel, int64_t y) { return rows_.row(channel * (end_ - begin_) + y - begin_); }

 private:
  int64_t begin_, end_;
  StagedRows rows_;
};

/// A stretch on the way back: logits as staged, saved totals [2], the result and its gradient [channels];
/// `logits_gradient` [taps] is what comes out.
struct GatherGradientRow {
  StagedRows logits, totals, out, gradient, logits_gradient;
  GatherGradientRow(const FilterShape& shape, int64_t pixels);
};
/// `values_gradient` may be null.
void gather_stretch_backward(const FilterShape& shape, const GatherSources& sources, const Stretch& at,
                             GatherGradientRow& row, GatherStrip* values_gradient);

}  // namespace ld
