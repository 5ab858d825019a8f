// A network as a file of weights holds it: its configuration, its graph, and a weight for each of the graph's
// parameters. Free of LibTorch; training programs and those that only denoise read files here alike.
#pragma once

#include <filesystem>

#include "graph/graph.h"
#include "models/network_config.h"
#include "weights/named_weights.h"

namespace ld {

struct NetworkWeights {
  NetworkConfig config;
  graph::Graph graph;
  NamedWeights weights;  // as float32, all finite
};

/// `model` is a weight file, a checkpoint folder, a run folder, or the name of released weights
/// (resolve_model). Throws Error when a parameter is missing, surplus, of another shape or not finite, and
/// before anything large is made when the file holds less or more than its network has. Weights in a
/// checkpoint must have the checksum that is noted beside them.
NetworkWeights read_network_weights(const std::filesystem::path& model);

}  // namespace ld
