// Where layers have no influence on the picture ([MH20] eq. 5).
#pragma once

#include <vector>

#include "graph/operators.h"
#include "ops/kernels/splat.h"
#include "runtime/row_window.h"

namespace ld {

/// Pixels of filtered layers that follow from what is filtered, without kernels, bit for bit:
/// - hidden: no pixel in reach of the kernels lets any light of a layer further in front through. Its
/// filtered
///   transmittance is 0, and what lies behind is multiplied with it.
/// - clear: the layer holds no light there and lets everything through. Sums of weights and of weights times
/// 1
///   are the same sums, so that their ratio is 1.
/// Only for values of alpha compositing: the light and, last, the transmittance of each layer, as they are.
class EmptyLayers {
 public:
  /// `channels` of each layer, the transmittance last.
  EmptyLayers(const FilterShape& shape, int64_t rows);

  struct Sources {
    RowWindow light, transmittance;          // channels - 1 planes a layer, and one
    const std::vector<graph::Span>& wanted;  // of each row the pixels that are there
  };
  /// Of the strip of sources [first, last): decides for those destinations that no other strip reaches.
  void look(const Sources& sources, int64_t first, int64_t last, int threads);

  const SplatSkips& skips() const { return skips_; }
  /// Writes what is known of row y to the filtered row, layers one behind the other. Returns how many pixels
  /// of layers that were.
  int64_t fill(int64_t y, PlanarTarget row) const;

  static int64_t bytes(const FilterShape& shape, int64_t rows);

 private:
  enum Kind : uint8_t { made = 0, hidden = 1, clear = 2 };

  void look_at_sources(const Sources& sources, int64_t y);
  void decide(int64_t y);

  FilterShape shape_;
  int64_t begin_ = 0, end_ = 0;      // destinations that the strip reaches
  int64_t first_ = 0, last_ = 0;     // sources
  SplatSkips opaque_, transparent_;  // of blocks of sources: all of their pixels are
  SplatSkips skips_;                 // of destinations, by kind
};

}  // namespace ld
