#include "export/parity.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/json_text.h"
#include "core/progress.h"
#include "core/random.h"
#include "dataset/input_tensors.h"
#include "frame/frame_file.h"
#include "frame/schema.h"
#include "models/initialise.h"
#include "training/run/config_file.h"
#include "weights/mix_weights.h"
#include "weights/model_file.h"
#include "weights/weight_file.h"

namespace ld {

using torch::Tensor;

namespace {

NetworkInput random_picture(const NetworkConfig& config, uint32_t index, int64_t batch, int64_t samples,
                            int64_t height, int64_t width) {
  RandomStream stream(1, RandomPurpose::test, index);
  const auto fill = [&](int64_t channels, const auto& draw) {
    const Tensor tensor = torch::empty({batch, samples, channels, height, width});
    for (int64_t i = 0; i < tensor.numel(); ++i) tensor.data_ptr<float>()[i] = draw();
    return tensor;
  };
  const Tensor valid = fill(1, [&] { return stream.uniform() < 0.125F ? 0.0F : 1.0F; });
  valid.select(3, height / 2).select(3, width / 2).zero_();
  // Mostly below 1, one in a hundred thirty times as bright.
  const Tensor radiance =
      fill(3, [&] { return stream.uniform() * (stream.uniform() < 0.01F ? 30.0F : 1.0F); });
  const Tensor features = fill(channel_count(config.features), [&] { return stream.uniform(); });
  return {features * valid, radiance * valid, valid};
}

}  // namespace

ExportSource load_source(const std::filesystem::path& model) {
  const std::filesystem::path file = resolve_model(model);
  return {load_network(file), read_weights_header(SafetensorsFile(file)).provenance};
}

void mix_in(const std::filesystem::path& model, double share, ExportSource& source) {
  mix_in_weights(model, share, *source.network, "--mix");
  auto json = source.provenance.empty()
                  ? nlohmann::ordered_json::object()
                  : nlohmann::ordered_json(parse_json(source.provenance, model.string()));
  json["mixed_with"] = fmt::format("{} of {}", share, model.filename().string());
  source.provenance = json.dump();
}

ExportSource untrained_source(const std::filesystem::path& config, uint64_t seed) {
  const ConfigNode root = read_train_tree(config);
  const ConfigNode* section = root.find("network");
  if (section == nullptr) fail_usage("{}: no section 'network'; expected a training config", config.string());
  const auto network_config = config_from_tree<NetworkConfig>(*section);
  if (network_config.auto_features())
    fail_usage("{}: network.features is '{}', which only a training resolves; name the features",
               config.string(), kAutoFeatures);
  ExportSource source;
  source.network = make_network(network_config);
  initialise(*source.network, seed);
  source.provenance = nlohmann::ordered_json({{"untrained", true}, {"seed", seed}}).dump();
  return source;
}

std::vector<NetworkInput> parity_inputs(const NetworkConfig& config,
                                        const std::vector<std::filesystem::path>& frames) {
  std::vector<NetworkInput> inputs = {random_picture(config, 0, 1, 4, 37, 53),
                                      random_picture(config, 1, 2, 3, 16, 16),
                                      random_picture(config, 2, 1, 8, 48, 64)};
  Progress progress("frames", static_cast<int64_t>(frames.size()));
  for (const std::filesystem::path& path : frames) {
    Faults faults;
    inputs.push_back(make_network_input({read_frame(path, config.features, faults)}, config.features));
    progress.advance();
  }
  return inputs;
}

std::shared_ptr<Network> rounded(const Network& network, DType type) {
  const std::shared_ptr<Network> copy = make_network(network.config());
  const torch::NoGradGuard no_graph;
  const auto weights = network.named_parameters();
  for (auto& parameter : copy->named_parameters()) {
    const Tensor& weight = weights[parameter.key()];
    parameter.value().copy_(type == DType::f16 ? weight.to(torch::kHalf).to(torch::kFloat32) : weight);
    if (!parameter.value().isfinite().all().item<bool>())
      fail("parameter '{}' reaches {}, beyond the largest float16, 65504; export with --dtype f32",
           parameter.key(), weight.abs().max().item<float>());
  }
  copy->eval();
  return copy;
}

std::vector<Tensor> outputs(Network& network, const std::vector<NetworkInput>& inputs, int frames) {
  const torch::InferenceMode no_graph;
  std::vector<Tensor> pictures;
  Progress progress("pictures to compare", static_cast<int64_t>(inputs.size()));
  for (const NetworkInput& input : inputs) {
    NetworkState state;
    for (int f = 1; network.remembers() && f < frames; ++f) network.forward(input, state);
    pictures.push_back(network.forward(input, state));
    progress.advance();
  }
  return pictures;
}

double largest_relative_difference(const std::vector<Tensor>& found, const std::vector<Tensor>& expected) {
  double largest = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    const Tensor difference = (found[i] - expected[i]).abs() / (expected[i].abs() + kParityEpsilon);
    if (!difference.isfinite().all().item<bool>()) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, difference.max().item<double>());
  }
  return largest;
}

Metadata export_metadata(const ExportSource& source, DType type, const Parity& weights, const Parity* onnx,
                         size_t pictures) {
  const auto measured = [](const Parity& parity) {
    return nlohmann::ordered_json(
        {{"largest_relative_difference", parity.largest_relative_difference}, {"allowed", parity.tolerance}});
  };
  nlohmann::ordered_json json = {
      {"program", "ld_export " LD_VERSION},
      {"dtype", type == DType::f16 ? "f16" : "f32"},
      {"difference", fmt::format("|a - b| / (|b| + {}), the largest over all pixels", kParityEpsilon)},
      {"pictures", pictures},
      {"rounded_weights", measured(weights)}};
  if (onnx != nullptr) json["onnx"] = measured(*onnx);
  Metadata metadata = make_weights_metadata(source.network->config(), source.provenance);
  metadata["export"] = json.dump();
  if (onnx != nullptr) metadata["format"] = "ld-onnx";
  return metadata;
}

}  // namespace ld
