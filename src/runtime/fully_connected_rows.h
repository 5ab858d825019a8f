// A fully connected network of a graph on rows of windows.
#pragma once

#include "graph/operators.h"
#include "ops/kernels/tile_network.h"
#include "weights/named_weights.h"

namespace ld {

/// Of layers named <weights>.0, <weights>.1, ..., whose first reads x_inputs channels and then those
/// that all items of a pixel share.
inline TileNetwork tile_network(const graph::FullyConnected& op, const NamedWeights& weights,
                                int64_t x_inputs, int64_t outputs) {
  std::vector<TileNetwork::Layer> layers;
  for (size_t i = 0; i < op.widths.size(); ++i) {
    const std::string name = op.weights + "." + std::to_string(i);
    const NamedWeight& weight = weights.at(name + ".weight");
    layers.push_back(
        {weight.values.data(), weights.at(name + ".bias").values.data(), weight.shape[0], weight.shape[1]});
  }
  TileNetwork::Layer& last = layers.back();
  last.weights += op.first_output * last.inputs;
  last.biases += op.first_output;
  last.outputs = outputs;
  return {std::move(layers), x_inputs, {op.activate_last, float(op.bound)}, /*for_backward=*/false};
}

}  // namespace ld
