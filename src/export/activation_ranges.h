// How large the activations are that a network's convolutions read. Free of LibTorch.
#pragma once

#include <array>
#include <map>

#include "frame/frame.h"
#include "graph/graph.h"
#include "runtime/row_window.h"
#include "weights/network_weights.h"

namespace ld {

/// Of each value of the graph that a convolution reads, over all frames that were run.
class ActivationRanges {
 public:
  explicit ActivationRanges(const NetworkWeights& network);

  /// Runs the network on a frame.
  void add(const Frame& frame, int threads);

  /// The magnitude that all but kBeyondRange of what a convolution of the graph read stay below, to an
  /// eighth. A few pixels reach a thousand times as far as all others (a firefly that no neighbour shares):
  /// steps as coarse as they would ask for cost more than their being cut off.
  float of(const graph::Node& convolution) const;
  static constexpr double kBeyondRange = 1e-4;

 private:
  /// Counts of magnitudes; a bin holds an eighth of an octave, the exponent and three bits of the float.
  static constexpr int kBinShift = 20;
  using Histogram = std::array<uint64_t, 1U << (31 - kBinShift)>;

  void add_rows(graph::ValueId value, const RowWindow& rows, int64_t begin, int64_t end);

  const NetworkWeights& network_;
  std::map<graph::ValueId, Histogram> seen_;
};

}  // namespace ld
