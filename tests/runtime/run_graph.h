// A network of LibTorch's, run as a graph.
#pragma once

#include "models/graphs/network_graph.h"
#include "models/network.h"
#include "runtime/executor.h"

namespace ld {

inline NamedWeights weights_of(const Network& network) {
  NamedWeights weights;
  for (const auto& entry : network.named_parameters()) {
    const torch::Tensor values = entry.value().detach().to(torch::kFloat32).contiguous();
    weights.add(entry.key(), {values.sizes().vec(),
                              {values.data_ptr<float>(), values.data_ptr<float>() + values.numel()}});
  }
  return weights;
}

inline Image in_runtime(const NetworkConfig& config, const NamedWeights& weights, const Frame& frame,
                        const ExecutionOptions& options = {}) {
  const graph::Graph graph = network_graph(config);
  return Execution(graph, weights, {frame.spp, frame.height, frame.width}, options).run(frame)[0];
}

}  // namespace ld
