// Which light a graph's picture is a mean of.
#pragma once

#include <optional>

#include "graph/graph.h"

namespace ld::graph {

struct LightReach {
  int64_t radius = 0;  // pixels to each side whose samples a pixel is a mean of
  /// Additions one behind the other in the filters' sums, for each layer or sample of a source where `layers`
  /// or `samples` says so: what bounds the rounding of the mean.
  int64_t additions = 0, layers = 1;
  bool samples = false;
  bool albedo = false, specular = false;  // what demodulation divides by, if at all
};

/// Of graph.output, where every pixel of it is a weighted mean of the samples around it whatever the weights
/// of the network: filters, partition and compositor are such means ([MH20] eq. 1 to 6), and so is modulation
/// where no surface reflects (models/demodulation.h). Nothing for other networks: those that predict light,
/// remember it, or blend resolutions.
std::optional<LightReach> light_reach(const Graph& graph);

}  // namespace ld::graph
