#include "training/checkpoint.h"

#include <fmt/ranges.h>

#include "core/error.h"
#include "core/file_io.h"
#include "training/optimizer/adam_state.h"
#include "training/run/checkpoint_folder.h"
#include "weights/checkpoint_files.h"
#include "weights/model_file.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

constexpr const char* kTrained = "trained.";  // weights that are not the averaged ones

using TensorsByName = std::vector<std::pair<std::string, torch::Tensor>>;

/// Values for all parameters, from a file that names them with this prefix.
TensorsByName read_parameters(const SafetensorsFile& file, const std::string& prefix,
                              const Network& network) {
  TensorsByName values;
  for (const auto& parameter : network.named_parameters()) {
    values.emplace_back(parameter.key(), read_tensor(file.tensor(prefix + parameter.key())));
    if (values.back().second.sizes() != parameter.value().sizes())
      fail("{}: '{}' has the shape [{}], in this run's network [{}]; use another --out", file.path().string(),
           prefix + parameter.key(), fmt::join(values.back().second.sizes().vec(), ", "),
           fmt::join(parameter.value().sizes().vec(), ", "));
  }
  return values;
}

void set_parameters(Network& network, const TensorsByName& values) {
  const torch::NoGradGuard no_graph;
  auto parameters = network.named_parameters();
  for (const auto& [name, value] : values) parameters[name].copy_(value);
}

}  // namespace

void write_checkpoint_files(const fs::path& folder, const TrainingState& state, const Network& network,
                            Optimizer& optimizer, const std::string& provenance) {
  save_network(folder / kCheckpointFiles[0], optimizer.average().network(), provenance, DType::f32);
  NamedTensors tensors = adam_state(optimizer.adam(), network);
  if (optimizer.average().active())
    for (const auto& parameter : network.named_parameters())
      tensors.emplace_back(kTrained + parameter.key(), parameter.value());
  write_tensors(folder / kCheckpointFiles[1], tensors, {{"format", "ld-optimizer"}});
  write_file_atomically(folder / kCheckpointFiles[2], state_to_json(state));
}

TrainingState read_checkpoint(const fs::path& checkpoint, Network& network, Optimizer& optimizer) {
  verify_checkpoint(checkpoint);
  const fs::path state_path = checkpoint / kCheckpointFiles[2];
  const TrainingState state = state_from_json(read_file(state_path, 1 << 20), state_path.string());
  const SafetensorsFile weights(checkpoint / kCheckpointFiles[0]), rest(checkpoint / kCheckpointFiles[1]);
  const TensorsByName validated = read_parameters(weights, "", network);
  const bool averaged = optimizer.average().active();
  const TensorsByName trained = averaged ? read_parameters(rest, kTrained, network) : validated;
  if (state.optimizer_steps > 0) set_adam_state(optimizer.adam(), network, rest, state.optimizer_steps);
  set_parameters(network, trained);
  if (averaged) set_parameters(optimizer.average().network(), validated);
  return state;
}

TrainingState share_checkpoint(const TrainingState& state, Network& network, Optimizer& optimizer,
                               ProcessGroup& group) {
  if (group.size() == 1) return state;
  const std::string what = "sharing the checkpoint";
  const TrainingState shared =
      state_from_json(group.broadcast(state_to_json(state), what), "state of rank 0");
  if (shared.optimizer_steps > 0 && !group.is_root())
    make_adam_state(optimizer.adam(), network, shared.optimizer_steps);
  std::vector<torch::Tensor> tensors;
  for (const torch::Tensor& parameter : network.parameters()) tensors.push_back(parameter.detach());
  if (optimizer.average().active())
    for (const torch::Tensor& parameter : optimizer.average().network().parameters())
      tensors.push_back(parameter.detach());
  if (shared.optimizer_steps > 0)
    for (const auto& [name, tensor] : adam_state(optimizer.adam(), network)) tensors.push_back(tensor);
  group.broadcast(tensors, what);
  return shared;
}

uint64_t checkpoint_bytes(const Network& network, const WeightAverage& average) {
  uint64_t parameters = 0;
  for (const torch::Tensor& parameter : network.parameters())
    parameters += static_cast<uint64_t>(parameter.numel());
  return parameters * sizeof(float) * (average.active() ? 4 : 3);
}

}  // namespace ld
