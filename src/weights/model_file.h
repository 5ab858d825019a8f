// A network and its weights, to and from one safetensors file whose metadata holds the whole network
// configuration (weights/weight_file.h).
#pragma once

#include <torch/torch.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "models/network.h"
#include "weights/named_weights.h"
#include "weights/safetensors.h"

namespace ld {

/// Tensors by name, on their way to a file, which does not know their device.
using NamedTensors = std::vector<std::pair<std::string, torch::Tensor>>;

void write_tensors(const std::filesystem::path& path, const NamedTensors& tensors, const Metadata& metadata);

/// A copy of one tensor of the file.
torch::Tensor read_tensor(const TensorView& view);

/// Writes all parameters as `type` (f32 keeps every bit; f16 is for release). `provenance` says where they
/// came from; `further` metadata is for people and other programs. Throws Error, naming it, when a parameter
/// is too large for f16.
void save_network(const std::filesystem::path& path, const Network& network, const std::string& provenance,
                  DType type, const Metadata& further = {});

/// The LibTorch network with its weights as float32. `model` is a weight file, a checkpoint or a run folder.
/// Throws Error when a parameter is missing, surplus, of another shape or not finite, and before anything
/// large is made when the file holds less or more than its network has. Weights in a checkpoint must have the
/// checksum that is noted beside them.
std::shared_ptr<Network> load_network(const std::filesystem::path& model);

/// A copy of all parameters, for the runtime (runtime/executor.h).
NamedWeights weights_of(const Network& network);

}  // namespace ld
