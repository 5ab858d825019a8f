// What the files of a checkpoint hold (their folders: training/run/checkpoint_folder.h):
//  - weights.safetensors: the weights that validate: the averaged ones where there are any;
//  - optimizer.safetensors: Adam's moments, and the trained weights where the others are averaged;
//  - state.json: the TrainingState.
#pragma once

#include <filesystem>
#include <string>

#include "training/distributed/process_group.h"
#include "training/optimizer/optimizer.h"
#include "training/run/training_state.h"

namespace ld {

/// Writes the three files into an existing folder. `provenance`: JSON that goes into the weights' metadata.
void write_checkpoint_files(const std::filesystem::path& folder, const TrainingState& state,
                            const Network& network, Optimizer& optimizer, const std::string& provenance);

/// Sets weights, moments and averaged weights as they were; returns the state. Throws Error when the
/// checkpoint is damaged or of another network; nothing has been set then.
TrainingState read_checkpoint(const std::filesystem::path& checkpoint, Network& network,
                              Optimizer& optimizer);

/// Gives all processes the state, weights, moments and averaged weights of rank 0.
TrainingState share_checkpoint(const TrainingState& state, Network& network, Optimizer& optimizer,
                               ProcessGroup& group);

/// Bytes of a checkpoint.
uint64_t checkpoint_bytes(const Network& network, const WeightAverage& average);

}  // namespace ld
