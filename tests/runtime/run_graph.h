// A network of LibTorch's, run as a graph.
#pragma once

#include "models/graphs/network_graph.h"
#include "runtime/executor.h"
#include "weights/model_file.h"

namespace ld {

inline Image in_runtime(const NetworkConfig& config, const NamedWeights& weights, const Frame& frame,
                        const ExecutionOptions& options = {}) {
  const graph::Graph graph = network_graph(config);
  return Execution(graph, weights, {frame.spp, frame.height, frame.width}, options).run(frame)[0];
}

}  // namespace ld
