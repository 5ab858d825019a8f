// What networks cost in the runtime on this machine: predicted from their graphs, and measured. Free of
// LibTorch.
#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "graph/extent.h"
#include "models/network_config.h"
#include "weights/network_weights.h"

namespace ld {

using graph::PictureExtent;

/// A network with random weights, of the size that they have when a training begins. The time that a network
/// takes does not depend on them.
NetworkWeights random_weights(const NetworkConfig& config);

/// The same in 8 bits (export/quantised_export.h).
NetworkWeights random_weights_in_eight_bits(const NetworkConfig& config);

struct NetworkTime {
  double ms = 0;         // median
  double memory_mb = 0;  // of the plan: arena and weights
};

/// The median over frames of random samples after a warm-up: of as many as half a second holds, 3 to 15.
/// Several networks take turns, so that all see the same machine; the slowest says how often. Throws Error
/// where the frame alone would take more memory than there is.
std::vector<NetworkTime> measure_networks(const std::vector<NetworkWeights>& networks,
                                          const PictureExtent& picture, int threads);
NetworkTime measure_network(const NetworkWeights& network, const PictureExtent& picture, int threads);

/// Rates of the operators: seconds for each unit of work, which is a multiply-add or, of operators that do
/// none, a number that they make.
class CostModel {
 public:
  /// Times graphs whose operators are all that the candidates have, each on a frame of this size.
  CostModel(const std::vector<NetworkConfig>& calibration, const PictureExtent& picture, int threads);

  /// Rates that were measured before.
  explicit CostModel(std::map<size_t, double> rates) : seconds_(std::move(rates)) {}
  const std::map<size_t, double>& rates() const { return seconds_; }

  /// Milliseconds for a frame. An operator that no graph of the calibration has counts as the dearest.
  double milliseconds(const NetworkConfig& config, const PictureExtent& picture) const;

 private:
  std::map<size_t, double> seconds_;  // of a unit of work, by graph::Operator's index
};

}  // namespace ld
