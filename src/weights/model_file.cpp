#include "weights/model_file.h"

#include <cstring>

#include "core/error.h"
#include "weights/network_weights.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

torch::ScalarType torch_type(DType type) {
  switch (type) {
    case DType::f16:
      return torch::kHalf;
    case DType::f32:
      return torch::kFloat32;
    case DType::f64:
      return torch::kFloat64;
    case DType::i64:
      return torch::kInt64;
    case DType::i8:
      return torch::kInt8;
    case DType::u8:
      return torch::kUInt8;
  }
  fail("a tensor type that no program of this project writes");
}

DType file_type(const torch::Tensor& tensor) {
  for (const DType type : {DType::f16, DType::f32, DType::f64, DType::i64, DType::i8, DType::u8})
    if (torch_type(type) == tensor.scalar_type()) return type;
  fail("a tensor of type {} cannot be written to safetensors", c10::toString(tensor.scalar_type()));
}

}  // namespace

void write_tensors(const std::filesystem::path& path, const NamedTensors& tensors, const Metadata& metadata) {
  std::vector<torch::Tensor> plain;  // keeps the data alive until it is written
  std::vector<TensorView> views;
  for (const auto& [name, tensor] : tensors) {
    plain.push_back(tensor.detach().cpu().contiguous());
    const torch::Tensor& data = plain.back();
    views.push_back({name, file_type(data), data.sizes().vec(), data.data_ptr(), data.nbytes()});
  }
  write_safetensors(path, views, metadata);
}

torch::Tensor read_tensor(const TensorView& view) {
  torch::Tensor tensor = torch::empty(view.shape, torch_type(view.type));
  if (view.bytes > 0) std::memcpy(tensor.data_ptr(), view.data, view.bytes);
  return tensor;
}

void save_network(const std::filesystem::path& path, const Network& network, const std::string& provenance,
                  DType type, const Metadata& further) {
  NamedTensors tensors;
  for (const auto& parameter : network.named_parameters()) {
    tensors.emplace_back(parameter.key(), parameter.value().detach().to(torch_type(type)));
    const torch::Tensor& stored = tensors.back().second;
    if (type == DType::f16 && !stored.isfinite().all().item<bool>())
      fail("parameter '{}' reaches {}, beyond the largest float16, 65504; write float32", parameter.key(),
           parameter.value().abs().max().item<float>());
  }
  Metadata metadata = make_weights_metadata(network.config(), provenance);
  metadata.insert(further.begin(), further.end());
  write_tensors(path, tensors, metadata);
}

std::shared_ptr<Network> load_network(const std::filesystem::path& model) {
  const NetworkWeights read = read_network_weights(model);
  const std::shared_ptr<Network> network = make_network(read.config);
  const torch::NoGradGuard no_grad;
  for (auto& parameter : network->named_parameters()) {
    const NamedWeight& stored = read.weights.at(parameter.key());
    parameter.value().copy_(
        torch::from_blob(const_cast<float*>(stored.values.data()), parameter.value().sizes()));
  }
  return network;
}

NamedWeights weights_of(const Network& network) {
  NamedWeights weights;
  for (const auto& entry : network.named_parameters()) {
    const torch::Tensor values = entry.value().detach().to(torch::kFloat32).contiguous();
    weights.add(entry.key(), {values.sizes().vec(),
                              {values.data_ptr<float>(), values.data_ptr<float>() + values.numel()}});
  }
  return weights;
}

}  // namespace ld
