// Networks as the programs that denoise run them: their graphs, planned for frames of one size.
#pragma once

#include "benchmark/workloads.h"
#include "runtime/executor.h"
#include "weights/network_weights.h"

namespace ld {

/// A network of a training configuration with Xavier weights.
NetworkWeights bench_weights(const NetworkConfig& config);

/// A network, its plan on LibTorch's number of threads, and a frame of random numbers in which every sample
/// is valid.
class PlannedNetwork {
 public:
  PlannedNetwork(NetworkWeights network, const PictureExtent& picture);
  PlannedNetwork(const PlannedNetwork&) = delete;
  PlannedNetwork& operator=(const PlannedNetwork&) = delete;

  void run() { execution_.run(frame_); }
  const Execution& execution() const { return execution_; }
  const graph::Graph& graph() const { return network_.graph; }

  /// Of a frame (models/graphs/network_cost.h).
  double multiply_adds() const;
  /// What must pass through memory at least: weights and the frame's features in, the picture out.
  double bytes() const;

 private:
  NetworkWeights network_;
  Frame frame_;
  Execution execution_;
};

}  // namespace ld
