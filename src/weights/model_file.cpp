#include "weights/model_file.h"

#include <fmt/ranges.h>

#include <cstring>
#include <set>

#include "core/error.h"
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
    case DType::u8:
      return torch::kUInt8;
  }
  fail("a tensor type that no program of this project writes");
}

DType file_type(const torch::Tensor& tensor) {
  for (const DType type : {DType::f16, DType::f32, DType::f64, DType::i64, DType::u8})
    if (torch_type(type) == tensor.scalar_type()) return type;
  fail("a tensor of type {} cannot be written to safetensors", c10::toString(tensor.scalar_type()));
}

}  // namespace

void write_tensors(const std::filesystem::path& path, const NamedTensors& tensors, const Metadata& metadata) {
  std::vector<torch::Tensor> plain;  // keeps the data alive until it is written
  std::vector<TensorView> views;
  for (const auto& [name, tensor] : tensors) {
    plain.push_back(tensor.detach().contiguous());
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

void save_model(const std::filesystem::path& path, const Network& network, const std::string& provenance,
                DType type) {
  NamedTensors tensors;
  for (const auto& parameter : network.named_parameters())
    tensors.emplace_back(parameter.key(), parameter.value().detach().to(torch_type(type)));
  write_tensors(path, tensors, make_weights_metadata(network.config(), provenance));
}

std::shared_ptr<Network> load_model(const std::filesystem::path& model) {
  const SafetensorsFile file(resolve_model(model));
  const std::shared_ptr<Network> network = make_network(read_weights_header(file).network);
  std::set<std::string> expected;
  const torch::NoGradGuard no_grad;
  for (auto& parameter : network->named_parameters()) {
    const torch::Tensor stored = read_tensor(file.tensor(parameter.key()));
    if (stored.sizes() != parameter.value().sizes())
      fail("{}: tensor '{}' has the shape [{}]; its network config needs [{}]; the file is damaged",
           file.path().string(), parameter.key(), fmt::join(stored.sizes().vec(), ", "),
           fmt::join(parameter.value().sizes().vec(), ", "));
    if (!stored.to(torch::kFloat32).isfinite().all().item<bool>())
      fail("{}: tensor '{}' holds NaN or infinity; the training diverged or the file is damaged",
           file.path().string(), parameter.key());
    parameter.value().copy_(stored);
    expected.insert(parameter.key());
  }
  for (const TensorView& view : file.tensors())
    if (expected.count(view.name) == 0)
      fail("{}: holds a tensor '{}' that its network config has no place for; the file is damaged",
           file.path().string(), view.name);
  return network;
}

}  // namespace ld
