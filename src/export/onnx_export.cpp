#include "export/onnx_export.h"

#include "core/error.h"
#include "core/file_io.h"
#include "export/onnx_evaluator.h"
#include "export/onnx_file.h"
#include "export/onnx_network.h"
#include "export/safetensors_export.h"
#include "graph/extent.h"
#include "models/graphs/network_graph.h"
#include "weights/model_file.h"

namespace ld {
namespace {

onnx::ModelProto translate(const Network& network, DType type) {
  std::vector<torch::Tensor> data;  // alive until the model holds copies
  std::vector<TensorView> views;
  for (const auto& parameter : network.named_parameters()) {
    data.push_back(
        parameter.value().detach().to(type == DType::f16 ? torch::kHalf : torch::kFloat32).contiguous());
    const torch::Tensor& weight = data.back();
    views.push_back({parameter.key(), type, weight.sizes().vec(), weight.data_ptr(), weight.nbytes()});
  }
  return onnx_model(network.config(), views);
}

}  // namespace

std::vector<torch::Tensor> empty_onnx_state(const NetworkConfig& config, const NetworkInput& input) {
  const graph::Graph graph = network_graph(config);
  const graph::PictureExtent picture = {input.valid.size(1), input.valid.size(3), input.valid.size(4)};
  std::vector<torch::Tensor> state;
  for (const graph::ValueId id : graph.state) {
    const graph::ValueExtent extent = extent_of(graph, id, picture);
    state.push_back(torch::zeros({input.valid.size(0), extent.planes, extent.height, extent.width}));
  }
  return state;
}

OnnxExport export_onnx(const ExportSource& source, const std::filesystem::path& out, DType type,
                       const std::vector<NetworkInput>& inputs, double allowed) {
  const std::shared_ptr<Network> network = rounded(*source.network, type);
  OnnxExport result;
  result.weights = rounding_parity(source, *network, type, inputs);
  result.graph.tolerance = allowed;

  onnx::ModelProto model = parse_onnx(onnx_bytes(translate(*network, type)), out.string());
  result.nodes = model.graph().node_size();
  {
    const torch::InferenceMode no_graph;
    const OnnxEvaluator evaluator(model);
    std::vector<torch::Tensor> found;
    for (const NetworkInput& input : inputs) {
      std::vector<torch::Tensor> state = empty_onnx_state(network->config(), input);
      for (int f = 1; !state.empty() && f < kParityFrames; ++f) evaluator.forward(input, state);
      found.push_back(evaluator.forward(input, state));
    }
    result.graph.largest_relative_difference =
        largest_relative_difference(found, outputs(*network, inputs, kParityFrames));
  }
  if (!result.graph.passed())
    fail(
        "{}: the ONNX graph computes something else than the network: largest relative difference {:.2g}, "
        "allowed "
        "{:.2g}; nothing was written; a network whose logits reach thousands differs by rounding alone: then "
        "give "
        "--allowed",
        out.string(), result.graph.largest_relative_difference, result.graph.tolerance);

  for (const auto& [key, text] :
       export_metadata(source, type, result.weights, &result.graph, inputs.size())) {
    onnx::StringStringEntryProto& entry = *model.add_metadata_props();
    entry.set_key(key);
    entry.set_value(text);
  }
  const std::string bytes = onnx_bytes(model);
  write_file_atomically(out, bytes);
  return result;
}

void write_check_data(const std::filesystem::path& out, const ExportSource& source, DType type,
                      const std::vector<NetworkInput>& inputs) {
  const std::vector<torch::Tensor> pictures = outputs(*rounded(*source.network, type), inputs);
  NamedTensors tensors;
  for (size_t i = 0; i < inputs.size(); ++i) {
    const std::string index = "_" + std::to_string(i);
    tensors.emplace_back("features" + index, inputs[i].features);
    tensors.emplace_back("radiance" + index, inputs[i].radiance);
    tensors.emplace_back("valid" + index, inputs[i].valid);
    tensors.emplace_back("image" + index, pictures[i]);
  }
  write_tensors(out, tensors, {{"format", "ld-check-data"}});
}

}  // namespace ld
