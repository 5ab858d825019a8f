// Inner loops of ops/kernel_splat.h for one picture, float32, for every SIMD width (Highway). Rows of sources
// are added one after the other to a strip of destinations, which keeps the largest exponent that has arrived
// at each pixel and rescales what it has summed when a larger one comes (the softmax of Milakov and
// Gimelshein 2018): one pass over logits that may exist for this row only. Strips meet in merge_row.
#pragma once

#include <vector>

#include "ops/kernels/filter.h"

namespace ld {

/// What the sources of rows [first, last) of a picture send: for each destination row in reach and each layer
/// (one for all when joint) the largest exponent, the sum of weights, and the sums of weighted values.
class SplatStrip {
 public:
  SplatStrip(const FilterShape& shape, bool joint, int64_t first, int64_t last);

  /// Begins anew with other rows, at most as many as it was made for.
  void restart(const FilterShape& shape, int64_t first, int64_t last);

  int64_t begin() const { return begin_; }
  int64_t end() const { return end_; }
  bool holds(int64_t y) const { return y >= begin_ && y < end_; }
  /// Pixel 0 of: the largest exponents, then the sums of weights, then of each channel, `pitch()` apart.
  float* row(int64_t layer, int64_t y) {
    return rows_.row(((joint_ ? 0 : layer) * (end_ - begin_) + y - begin_) * planes_);
  }
  int64_t pitch() const { return rows_.pitch(); }
  int64_t floats() const { return rows_.floats(); }

 private:
  int64_t begin_, end_, planes_;
  bool joint_;
  StagedRows rows_;
};

/// A stretch of sources: logits [layers * taps], which become exponents; log_n [layers]; values
/// [layers * channels].
struct SplatSourcesRow {
  StagedRows logits, log_n, values;
  SplatSourcesRow(const FilterShape& shape, int64_t pixels);
};

/// Bounds the logits of a staged stretch, subtracts the largest of each pixel and adds log n: the exponents
/// e_l + log n_l of the header.
void splat_exponents(const FilterShape& shape, SplatSourcesRow& sources, int64_t count);

/// Destinations of a strip that need not be made: what they have got so far then stays as it is, or not.
class SplatSkips {
 public:
  static constexpr int64_t kBlock = 8;  // pixels of a row

  SplatSkips(const FilterShape& shape, int64_t rows)
      : blocks_((shape.width + kBlock - 1) / kBlock),
        rows_(rows),
        skips_(size_t(shape.layers * rows * blocks_)) {}

  int64_t blocks() const { return blocks_; }
  /// Of the strip's row `row`, block by block: 0 for those that are made.
  uint8_t* row(int64_t layer, int64_t row) { return skips_.data() + (layer * rows_ + row) * blocks_; }
  const uint8_t* row(int64_t layer, int64_t row) const {
    return const_cast<SplatSkips*>(this)->row(layer, row);
  }
  int64_t bytes() const { return int64_t(skips_.size()); }

 private:
  int64_t blocks_, rows_;
  std::vector<uint8_t> skips_;
};

/// Adds a stretch whose exponents are ready to the strip; `skips`, where given, has its rows.
void splat_stretch(const FilterShape& shape, const SplatSourcesRow& sources, const Stretch& at,
                   SplatStrip& strip, const SplatSkips* skips = nullptr);

/// Where results go; the last two may be null.
struct SplatResult {
  float* out;      // [layers or 1][channels]
  float* largest;  // [layers or 1]: the largest exponent
  float* inverse;  // [layers or 1]: 1 / the sum of weights, 0 where nothing arrived
  int64_t plane;   // floats from one of these planes to the next

  /// The same, `offset` pixels on.
  SplatResult at(int64_t offset) const {
    return {out + offset, largest == nullptr ? nullptr : largest + offset,
            inverse == nullptr ? nullptr : inverse + offset, plane};
  }
};
/// Row y of the result, from all strips that hold it; `result` is where that row goes.
void merge_row(const FilterShape& shape, bool joint, const std::vector<SplatStrip*>& strips, int64_t y,
               const SplatResult& result);

/// Destinations with margins for the backward pass: [layers or 1][H] rows of the largest exponent, the
/// inverse weight, and each channel's gradient and result.
class SplatDestinations {
 public:
  SplatDestinations(const FilterShape& shape, bool joint);
  int64_t planes() const { return 2 + 2 * channels_; }
  float* row(int64_t layer, int64_t y) { return rows_.row(((joint_ ? 0 : layer) * height_ + y) * planes()); }
  int64_t pitch() const { return rows_.pitch(); }
  /// Copies row y of every plane.
  void fill_row(const SplatResult& saved, const float* gradient, int64_t width, int64_t layers, int64_t y);

 private:
  int64_t height_, channels_;
  bool joint_;
  StagedRows rows_;
};

/// Scratch of splat_stretch_backward.
struct SplatGradientRow {
  StagedRows logits;  // [layers * taps]: the result, at a stretch
  StagedRows log_n;   // [layers]
  StagedRows values;  // [layers * channels]
  std::vector<int32_t> argmax;
  SplatGradientRow(const FilterShape& shape, int64_t pixels);
};

/// The gradients of a staged stretch, whose logits become probabilities on the way.
void splat_stretch_backward(const FilterShape& shape, SplatSourcesRow& sources, SplatDestinations& to,
                            const Stretch& at, SplatGradientRow& gradients);

}  // namespace ld
