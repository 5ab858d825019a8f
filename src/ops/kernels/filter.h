// What the kernels of the filters (splat.h, gather.h) share: sizes, and logits of a stretch of one row in the
// cache. Free of LibTorch.
#pragma once

#include <algorithm>

#include "ops/kernels/dense.h"

namespace ld {

struct FilterShape {
  int64_t layers, kernel, channels, height, width;
  int64_t taps() const { return kernel * kernel; }
  int64_t radius() const { return kernel / 2; }
  int64_t plane() const { return height * width; }
};

/// Pixels [x, x + count) of row y.
struct Stretch {
  int64_t y, x, count;
};

/// Columns before and after a row that loads may touch: `reach` pixels and the rest of a vector.
inline int64_t row_margin(int64_t reach) {
  return padded(reach) + kPixelStep;
}

/// Planes of a picture in memory: plane c of pixel p is data[c * stride + p].
struct Planes {
  const float* data = nullptr;
  int64_t count = 0, stride = 0;
};

/// Rows of `pitch` floats for a stretch of at most `pixels` pixels, with margins that hold `outside`.
class StagedRows {
 public:
  StagedRows(int64_t rows, int64_t pixels, int64_t reach, float outside)
      : margin_(row_margin(reach)),
        pixels_(padded(pixels)),
        pitch_(pixels_ + 2 * margin_),
        rows_(rows),
        memory_(hwy::AllocateAligned<float>(size_t(std::max<int64_t>(rows * pitch_, 1)))) {
    std::fill_n(memory_.get(), rows * pitch_, outside);
  }

  float* row(int64_t index) { return memory_.get() + index * pitch_ + margin_; }
  const float* row(int64_t index) const { return memory_.get() + index * pitch_ + margin_; }
  int64_t pitch() const { return pitch_; }
  int64_t rows() const { return rows_; }
  int64_t floats() const { return rows_ * pitch_; }

  /// Sets what is behind pixel `count` of every row, up to where its margin begins.
  void fill_behind(int64_t count, float outside) {
    if (count == pixels_) return;
    for (int64_t r = 0; r < rows_; ++r) std::fill(row(r) + count, row(r) + pixels_, outside);
  }

 private:
  int64_t margin_, pixels_, pitch_, rows_;
  Floats memory_;
};

/// Pixels of a stretch, so that `planes` rows of logits stay near the core: even shares of a row, at most
/// 144.
inline int64_t stretch_pixels(int64_t planes, int64_t width) {
  const int64_t most =
      std::clamp<int64_t>((int64_t(1) << 19) / std::max<int64_t>(planes, 1) / 48 * 48, 48, 144);
  const int64_t parts = (width + most - 1) / most;
  return padded((width + parts - 1) / parts);
}

}  // namespace ld
