// Checkpoints: folders RUN/checkpoints/step_00000500 with weights.safetensors, optimizer.safetensors,
// state.json and checksums.json. They are written beside and renamed into place; the links `last` and `best`
// point at two of them, and only those two are kept.
#pragma once

#include <torch/torch.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "models/network.h"

namespace ld {

/// All that a run must remember besides weights and optimiser. Crops, flips and the order of the data follow
/// from the step (dataset/training_set.h).
struct TrainingState {
  int64_t step = 0;             // steps done
  int64_t optimizer_steps = 0;  // of these, steps that Adam took (others had gradients that were not finite)
  double best_score = std::numeric_limits<double>::infinity();  // lowest validation loss
  int64_t best_step = 0;
  std::string dataset;  // checksum of the manifest that the run trains on
};

class CheckpointFolder {
 public:
  explicit CheckpointFolder(std::filesystem::path run);

  /// Links `last`, and `best` too when `best` is true, to the new checkpoint and removes those that neither
  /// names.
  void write(const TrainingState& state, const Network& network, torch::optim::Adam& optimizer, bool best);

  /// The checkpoint that `last` names, if there is one.
  std::optional<std::filesystem::path> last() const;

 private:
  std::filesystem::path folder_;
};

/// Throws Error when a file is missing or does not match its checksum.
TrainingState read_checkpoint(const std::filesystem::path& checkpoint, Network& network,
                              torch::optim::Adam& optimizer);

}  // namespace ld
