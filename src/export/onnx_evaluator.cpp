#include "export/onnx_evaluator.h"

#include <cstring>

#include "core/error.h"
#include "export/onnx_network.h"
#include "export/onnx_operators.h"

namespace ld {

using torch::Tensor;

namespace {

torch::ScalarType type_of(const onnx::TensorProto& proto) {
  switch (proto.data_type()) {
    case onnx::TensorProto::FLOAT:
      return torch::kFloat32;
    case onnx::TensorProto::FLOAT16:
      return torch::kHalf;
    case onnx::TensorProto::INT64:
      return torch::kInt64;
    default:
      fail("ONNX tensor {}: a type that this project does not write", proto.name());
  }
}

Tensor read_initializer(const onnx::TensorProto& proto) {
  const std::vector<int64_t> sizes(proto.dims().begin(), proto.dims().end());
  const Tensor tensor = torch::empty(sizes, type_of(proto));
  if (proto.raw_data().size() != tensor.nbytes())
    fail("ONNX tensor {}: {} bytes, expected {}", proto.name(), proto.raw_data().size(), tensor.nbytes());
  std::memcpy(tensor.data_ptr(), proto.raw_data().data(), tensor.nbytes());
  return tensor;
}

}  // namespace

OnnxEvaluator::OnnxEvaluator(onnx::ModelProto model) : model_(std::move(model)) {
  for (const onnx::TensorProto& proto : model_.graph().initializer())
    initializers_[proto.name()] = read_initializer(proto);
  for (int i = 0; i < model_.graph().node_size(); ++i)
    for (const std::string& input : model_.graph().node(i).input()) last_use_[input] = i;
}

Tensor OnnxEvaluator::forward(const NetworkInput& input, std::vector<Tensor>& state) const {
  std::map<std::string, Tensor> values = {
      {"features", input.features}, {"radiance", input.radiance}, {"valid", input.valid}};
  for (size_t part = 0; part < state.size(); ++part) values[onnx_state(part)] = state[part];
  for (int i = 0; i < model_.graph().node_size(); ++i) {
    const onnx::NodeProto& node = model_.graph().node(i);
    std::vector<Tensor> inputs;
    for (const std::string& name : node.input()) {
      const auto initializer = initializers_.find(name);
      if (name.empty())
        inputs.emplace_back();
      else if (initializer != initializers_.end())
        inputs.push_back(initializer->second);
      else
        inputs.push_back(values.at(name));
    }
    const std::vector<Tensor> outputs = run_onnx_node(node, inputs);
    inputs.clear();
    for (int j = 0; j < node.output_size(); ++j) values[node.output(j)] = outputs[size_t(j)];
    for (const std::string& name : node.input())
      if (const auto use = last_use_.find(name); use->second == i) values.erase(name);
  }
  for (size_t part = 0; part < state.size(); ++part) state[part] = values.at(onnx_next_state(part));
  return values.at("image");
}

}  // namespace ld
