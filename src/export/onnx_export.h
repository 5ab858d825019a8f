// A checkpoint to an ONNX model, and the proof that the model computes the same.
#pragma once

#include <filesystem>
#include <vector>

#include "export/parity.h"

namespace ld {

struct OnnxExport {
  Parity weights;  // what rounding the weights to the number format changes
  Parity graph;    // the ONNX graph against the C++ network with the rounded weights
  int64_t nodes = 0;
};

/// Writes the network as an ONNX model (export/onnx_network.h) to `out`, atomically, after ONNX's own checker
/// and shape inference and after both differences were measured on `inputs`: the graph as it was read back,
/// run node by node (export/onnx_evaluator.h). The metadata holds them. Throws Error when one of the checks
/// fails, for the graph by more than `allowed`; then nothing is left behind.
OnnxExport export_onnx(const ExportSource& source, const std::filesystem::path& out, DType type,
                       const std::vector<NetworkInput>& inputs, double allowed = kOnnxTolerance);

/// What a model with a state is given at the first frame of a sequence: zeros of the sizes that such frames
/// leave. Empty for networks that keep nothing.
std::vector<torch::Tensor> empty_onnx_state(const NetworkConfig& config, const NetworkInput& input);

/// Writes inputs and the C++ network's outputs for other programs to compare with, as safetensors:
/// features_0, radiance_0, valid_0, image_0, features_1, ...
void write_check_data(const std::filesystem::path& out, const ExportSource& source, DType type,
                      const std::vector<NetworkInput>& inputs);

}  // namespace ld
