// How large the activations are that a network's convolutions read. Free of LibTorch.
#pragma once

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

  /// The largest magnitude among all that a convolution of the graph read.
  float of(const graph::Node& convolution) const;

 private:
  void add_rows(graph::ValueId value, const RowWindow& rows, int64_t begin, int64_t end);

  const NetworkWeights& network_;
  std::map<graph::ValueId, float> largest_;
};

}  // namespace ld
