#include "tuning/released_start.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <vector>

#include "graph/extent.h"
#include "models/graphs/network_graph.h"
#include "weights/network_weights.h"
#include "weights/released.h"

namespace ld {
namespace {

/// What the shapes of weights do not say.
auto kind_of(const NetworkConfig& c) {
  return std::tie(c.name, c.layers, c.compositing, c.kernel_size, c.unet.upsampling, c.exposure_normalisation,
                  c.means, c.demodulation, c.logit_bound, c.rejection);
}

bool have_equal_shapes(const graph::Graph& a, const graph::Graph& b) {
  const std::vector<graph::Parameter> of_a = parameters(a), of_b = parameters(b);
  return std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                    [](const graph::Parameter& x, const graph::Parameter& y) {
                      return x.name == y.name && x.shape == y.shape;
                    });
}

std::map<std::string, NetworkWeights> read_released() {
  std::map<std::string, NetworkWeights> all;
  for (const std::string& name : released_models()) all.emplace(name, read_network_weights(name));
  return all;
}

}  // namespace

std::string released_start(const NetworkConfig& network) {
  static const std::map<std::string, NetworkWeights> kReleased = read_released();  // once for all candidates
  for (const auto& [name, released] : kReleased) {
    if (kind_of(released.config) != kind_of(network)) continue;
    NetworkConfig alike = network;
    alike.features = released.config.features;
    alike.optional = released.config.optional;
    if (have_equal_shapes(network_graph(alike), released.graph)) return name;
  }
  return "";
}

}  // namespace ld
