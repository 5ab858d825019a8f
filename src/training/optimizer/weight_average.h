// Averaged weights: an exponential moving average over the steps (Polyak and Juditsky 1992 with exponential
// weights), which varies less from step to step than the weights that are trained.
#pragma once

#include <memory>

#include "models/network.h"

namespace ld {

class WeightAverage {
 public:
  /// Begins at the network's weights. With `decay` 0 there is no average: network() is what is trained.
  WeightAverage(std::shared_ptr<Network> trained, double decay);

  bool active() const { return average_ != trained_; }

  /// After the trained weights took step n (from 1): average = d average + (1 - d) weights, where
  /// d = min(decay, (1 + n) / (10 + n)) lets go of the random beginning.
  void update(int64_t n);

  /// What validates and is saved as the weights of the run.
  Network& network() { return *average_; }
  const Network& network() const { return *average_; }

 private:
  std::shared_ptr<Network> trained_, average_;
  double decay_;
};

/// The decay d of step n in update().
double average_decay(double decay, int64_t n);

/// Copies all parameters between networks of one configuration.
void copy_parameters(const Network& from, Network& to);

/// Another network of the same configuration, weights and device.
std::shared_ptr<Network> copy_of(const Network& network);

}  // namespace ld
