// Trainings of milliseconds.
#pragma once

#include <string>

#include "core/file_io.h"
#include "frame/manifest.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"
#include "training/trainer.h"

namespace ld {

/// 2 batches an epoch of a data set of 4 frames; a log row each 5 steps, validation and checkpoint each 10.
inline TrainConfig tiny_config(const std::filesystem::path& data, int64_t max_steps) {
  auto config = config_from_tree<TrainConfig>(parse_config(tiny_network_yaml(), "tiny"));
  config.data.path = data.string();
  config.data.crop = 8;
  config.data.batch = 2;
  config.optimizer.schedule = "cosine";
  config.run = {max_steps, 5, 10, 10};
  config.watch.entropy = 0;  // the reference is the mean of the samples: kernels of one tap are right
  return config;
}

/// Weights, optimiser (with the trained weights where others are averaged) and state of the last checkpoint.
inline std::string last_checkpoint(const std::filesystem::path& run) {
  std::string bytes;
  for (const char* name : {"weights.safetensors", "optimizer.safetensors", "state.json"})
    bytes += read_file(run / "checkpoints/last" / name);
  return bytes;
}

/// All parameters of a network, one after the other.
inline torch::Tensor all_parameters(const Network& network) {
  std::vector<torch::Tensor> flat;
  for (const torch::Tensor& parameter : network.parameters()) flat.push_back(parameter.detach().flatten());
  return torch::cat(flat);
}

/// A data set of two sequences of six frames to train on and a still that validates, and a training on clips
/// of three frames.
inline TrainConfig two_sequences(const std::filesystem::path& data) {
  write_tiny_dataset(data, 12);
  Manifest manifest = read_manifest(data);
  for (ManifestFrame& frame : manifest.frames)
    if (frame.split == "train") {
      frame.sequence = frame.index / 6;
      frame.position = frame.index % 6;
    }
  add_to_manifest(data, manifest);
  TrainConfig config = tiny_config(data, 4);
  config.data.clip = 3;
  return config;
}

}  // namespace ld
