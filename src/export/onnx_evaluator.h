// Runs an ONNX model that this project wrote, with LibTorch's operators: the proof at export that the file
// computes what the C++ network computes, on machines that have no ONNX runtime (Debian 12 has none). Slow;
// for use, run the file in a runtime.
#pragma once

#include <onnx/onnx_pb.h>
#include <torch/torch.h>

#include <map>
#include <string>
#include <vector>

#include "models/network_input.h"

namespace ld {

class OnnxEvaluator {
 public:
  /// Reads the initializers. Throws Error for one of a type or size that this project does not write.
  explicit OnnxEvaluator(onnx::ModelProto model);

  /// The model's output `image` [B, 3, H, W]. Of a model with a state, `state` is what the frame before has
  /// left (export/onnx_network.h), and receives what this one leaves.
  torch::Tensor forward(const NetworkInput& input, std::vector<torch::Tensor>& state) const;
  torch::Tensor forward(const NetworkInput& input) const {
    std::vector<torch::Tensor> none;
    return forward(input, none);
  }

 private:
  onnx::ModelProto model_;
  std::map<std::string, torch::Tensor> initializers_;
  std::map<std::string, int> last_use_;  // index of the node after which a value is not needed any more
};

}  // namespace ld
