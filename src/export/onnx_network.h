// Whole networks as ONNX models: their graphs (models/graphs/), node by node. Free of LibTorch.
#pragma once

#include <onnx/onnx_pb.h>

#include <string>
#include <vector>

#include "graph/graph.h"
#include "models/network_config.h"
#include "weights/safetensors.h"

namespace ld {

/// The network with these weights (float32 or float16), names as in the weight file. Inputs, all float32:
/// features [B, S, F, H, W] encoded as frame/schema.h says, radiance [B, S, 3, H, W] linear, valid
/// [B, S, 1, H, W]; output image [B, 3, H, W]; any B, S, H and W from 1. What the input may hold is as for
/// Network::forward. A network whose graph has a state has its parts as further inputs, state0, state1, ...,
/// of what the frame before has left, zeros at the first frame, and as outputs next_state0, ... Throws Error
/// when a weight is missing or is none of the network's.
onnx::ModelProto onnx_model(const NetworkConfig& config, const std::vector<TensorView>& weights);

/// The same of any graph whose first node encodes a frame.
onnx::ModelProto onnx_model(const graph::Graph& network, const std::vector<TensorView>& weights);

/// The names of such an input, and of the output that the next frame takes in its place.
std::string onnx_state(size_t part);
std::string onnx_next_state(size_t part);

}  // namespace ld
