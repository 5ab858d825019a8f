// The training loop: crops in, Adam steps, validation, checkpoints, logs.
#pragma once

#include <torch/torch.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "dataset/training_set.h"
#include "losses/loss.h"
#include "models/network.h"
#include "training/checkpoint.h"
#include "training/config.h"
#include "training/event_log.h"

namespace ld {

class Trainer {
 public:
  /// Makes the run folder, or continues the run that it holds. Throws UsageError when the folder holds
  /// another configuration (all but the `run:` section counts) or the configuration does not fit the data;
  /// Error for bad data.
  Trainer(TrainConfig config, std::filesystem::path run);

  /// Trains to the last step, or until SIGINT or SIGTERM; a checkpoint is written in both cases.
  void train();

  const TrainingState& state() const { return state_; }
  int64_t total_steps() const { return total_steps_; }
  const Network& network() const { return *network_; }

 private:
  void resume();
  double take_step();
  bool limit_gradients();
  std::map<std::string, double> validate();
  bool note_score(const std::map<std::string, double>& scores);

  TrainConfig config_;
  std::filesystem::path run_;
  TrainingSet training_set_;
  std::vector<std::unique_ptr<FrameStore>> validation_;  // empty when no data set has a validation split
  std::shared_ptr<Network> network_;
  Loss loss_;
  torch::optim::Adam optimizer_;
  CheckpointFolder checkpoints_;
  TrainingState state_;
  int64_t total_steps_;
  int64_t skipped_in_a_row_ = 0;  // steps without finite gradients
};

}  // namespace ld
