#include "training/optimizer/weight_average.h"

#include <algorithm>

namespace ld {

double average_decay(double decay, int64_t n) {
  return std::min(decay, static_cast<double>(1 + n) / static_cast<double>(10 + n));
}

void copy_parameters(const Network& from, Network& to) {
  const torch::NoGradGuard no_graph;
  const auto source = from.named_parameters();
  for (auto& parameter : to.named_parameters()) parameter.value().copy_(source[parameter.key()]);
}

std::shared_ptr<Network> copy_of(const Network& network) {
  std::shared_ptr<Network> copy = make_network(network.config());
  copy->to(network.device());
  copy_parameters(network, *copy);
  return copy;
}

WeightAverage::WeightAverage(std::shared_ptr<Network> trained, double decay)
    : trained_(std::move(trained)), average_(decay > 0 ? copy_of(*trained_) : trained_), decay_(decay) {}

void WeightAverage::update(int64_t n) {
  if (!active()) return;
  const torch::NoGradGuard no_graph;
  const auto weights = trained_->named_parameters();
  for (auto& average : average_->named_parameters())
    average.value().lerp_(weights[average.key()], 1 - average_decay(decay_, n));
}

}  // namespace ld
