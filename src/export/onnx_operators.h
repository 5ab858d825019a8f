// The ONNX operators that our models consist of, computed by LibTorch.
#pragma once

#include <onnx/onnx_pb.h>
#include <torch/torch.h>

#include <string>
#include <vector>

namespace ld {

/// The outputs of one node; inputs that were left out are undefined tensors. Throws Error for an operator or
/// an attribute that our models do not use.
std::vector<torch::Tensor> run_onnx_node(const onnx::NodeProto& node,
                                         const std::vector<torch::Tensor>& inputs);

}  // namespace ld
