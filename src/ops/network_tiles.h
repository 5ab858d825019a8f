// Weights in tensors to the network that runs on tiles.
#pragma once

#include <torch/torch.h>

#include <vector>

#include "ops/fully_connected.h"
#include "ops/kernels/tile_network.h"

namespace ld {

/// The weights as their kernels read them.
inline FullyConnectedWeights contiguous(const FullyConnectedWeights& network) {
  FullyConnectedWeights plain;
  plain.bound = network.bound;
  for (const torch::Tensor& weight : network.weights) plain.weights.push_back(weight.contiguous());
  for (const torch::Tensor& bias : network.biases) plain.biases.push_back(bias.contiguous());
  return plain;
}

/// Contiguous float32 weights [outputs, inputs] and biases [outputs] of each layer, which must outlive it.
inline TileNetwork tile_network(const std::vector<torch::Tensor>& weights,
                                const std::vector<torch::Tensor>& biases, int64_t x_inputs,
                                TileNetwork::Last last, bool for_backward) {
  std::vector<TileNetwork::Layer> layers;
  for (size_t i = 0; i < weights.size(); ++i)
    layers.push_back(
        {weights[i].data_ptr<float>(), biases[i].data_ptr<float>(), weights[i].size(0), weights[i].size(1)});
  return TileNetwork(std::move(layers), x_inputs, last, for_backward);
}

}  // namespace ld
