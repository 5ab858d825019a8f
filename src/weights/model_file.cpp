#include "weights/model_file.h"

#include <fmt/ranges.h>

#include <cstring>
#include <set>

#include "core/error.h"
#include "frame/schema.h"
#include "models/unet.h"
#include "weights/checkpoint_files.h"
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

/// Parameters of fully connected layers of these widths, or of convolutions of so many taps.
int64_t chain_count(const std::vector<int64_t>& widths, int64_t taps = 1) {
  int64_t count = 0;
  for (size_t i = 0; i + 1 < widths.size(); ++i) count += widths[i + 1] * (widths[i] * taps + 1);
  return count;
}

std::vector<int64_t> chain(int64_t inputs, std::vector<int64_t> widths) {
  widths.insert(widths.begin(), inputs);
  return widths;
}

int64_t unet_count(const UNetConfig& config, int64_t inputs) {
  constexpr int64_t kTaps = 9;
  std::vector<int64_t> skips;
  int64_t channels = inputs, count = 0;
  const auto add = [&](const std::vector<int64_t>& widths, int64_t skip) {
    count += chain_count(chain(channels + skip, widths), kTaps);
    channels = widths.back();
  };
  for (const auto& widths : config.encoder) {
    skips.push_back(channels);
    add(widths, 0);
  }
  add(config.bottleneck, 0);
  for (const auto& widths : config.decoder) {
    add(widths, skips.back());
    skips.pop_back();
  }
  add({config.context}, 0);
  return count;
}

/// Before make_network() takes memory for what a damaged or foreign header asks for.
void expect_size(const SafetensorsFile& file, const NetworkConfig& config) {
  try {
    check_network(config);
  } catch (const UsageError& error) {  // nobody typed this network: the file is wrong
    fail("{}: metadata: network: {}", file.path().string(), error.what());
  }
  int64_t held = 0;
  for (const TensorView& tensor : file.tensors())
    held += static_cast<int64_t>(tensor.bytes / dtype_bytes(tensor.type));
  const int64_t expected = parameter_count(config);
  if (held != expected)
    fail("{}: holds {} numbers, but the network of its metadata ('{}') has {}; the file is damaged",
         file.path().string(), held, config.name, expected);
}

}  // namespace

int64_t parameter_count(const NetworkConfig& config) {
  const NetworkTraits& network = network_traits(config.name);
  const bool pixels = network.sources == Sources::pixels, levels = network.has_levels;
  const int64_t embedding = config.sample_reducer.back(), taps = config.kernel_size * config.kernel_size;
  int64_t count =
      chain_count(chain(int64_t{pixels ? 2 : 1} * channel_count(config.features), config.sample_reducer)) +
      unet_count(config.unet, embedding);
  const auto generator = [&](int64_t context, int64_t outputs) {
    std::vector<int64_t> widths = chain(embedding + context, config.kernel_generator);
    widths.push_back(outputs);
    count += chain_count(widths);
  };
  for (int64_t i = 0; i < (levels ? config.levels : 1); ++i)
    generator(UNet::feature_channels(config.unet, i), taps + (levels && i == 0 ? config.levels : 0));
  if (network.sources == Sources::layers) {
    std::vector<int64_t> widths = chain(embedding + config.unet.context, config.sample_partitioner);
    widths.push_back(config.layers);
    count += chain_count(widths);
  }
  if (config.rejection) count += chain_count({embedding + config.unet.context, 1});
  if (config.demodulation != "none") count += chain_count({1 + config.unet.context, 1});
  return count;
}

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

std::shared_ptr<Network> load_model(const std::filesystem::path& model) {
  const std::filesystem::path path = resolve_model(model);
  if (exists(path.parent_path() / "checksums.json") && path.filename() == kCheckpointFiles[0])
    verify_checkpoint_file(path.parent_path(), kCheckpointFiles[0]);
  const SafetensorsFile file(path);
  const NetworkConfig config = read_weights_header(file).network;
  expect_size(file, config);
  const std::shared_ptr<Network> network = make_network(config);
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
