// The training loop: steps, validation, checkpoints, logs. What comes when is decided by the run's course
// (training/run/course.h).
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "dataset/training_set.h"
#include "losses/loss.h"
#include "models/network.h"
#include "training/checkpoint.h"
#include "training/distributed/process_group.h"
#include "training/kernel_statistics.h"
#include "training/optimizer/optimizer.h"
#include "training/run/checkpoint_folder.h"
#include "training/run/config.h"
#include "training/run/course.h"
#include "training/run/pace.h"
#include "training/run/run_folder.h"
#include "training/run/training_state.h"
#include "training/run_log.h"
#include "training/validation.h"

namespace ld {

struct TrainerOptions {
  ProcessGroup* group = nullptr;  // processes that train together; null: this one alone
  std::string command;            // line that started the program, for the run's notes
  Loss loss;                      // in place of the configuration's
  KernelProbe kernel_probe;       // in place of kernel_statistics()
};

class Trainer {
 public:
  /// Makes the run folder, or continues the run that it holds from its newest whole checkpoint. Throws
  /// UsageError when the folder holds another configuration (training/run/run_folder.h) or the configuration
  /// does not fit the data; Error for bad data, when no checkpoint is whole, and when another process trains
  /// into the folder.
  Trainer(TrainConfig config, std::filesystem::path run, const TrainerOptions& options = {});

  /// Trains to the last step, until the time is up, or until SIGINT or SIGTERM; a checkpoint is written in
  /// all cases, also when an error ends the run. A training that collapses (training/run/collapse_watch.h)
  /// goes back to its best checkpoint at half the learning rate. Throws Error when it has done so
  /// watch.retries times, losses or gradients are not finite for run.max_skipped steps in a row, a peer is
  /// lost, data are bad, or the last checkpoint finds no room.
  void train();

  const TrainingState& state() const { return course_.state(); }
  /// Of a training on samples as targets: what the best weights gain on held-out frames, or why those of the
  /// beginning are the best, in a sentence; "" for other trainings.
  const std::string& verdict() const { return verdict_; }
  /// Of the schedule; 0 when a signal came while run.minutes was turned into steps: then there is no run.
  int64_t total_steps() const { return course_.total_steps(); }
  /// The network that is trained, and the averaged one that validates (the same without optimizer.ema).
  const Network& network() const { return *network_; }
  const Network& averaged_network() const { return optimizer_.average().network(); }

 private:
  // trainer_begin.cpp
  void open_run(const std::string& command, const std::string& dataset, int64_t total_steps);
  TrainingState resume(const TrainingState& fresh);
  void announce();
  // trainer.cpp
  void run_steps();
  bool must_stop();
  double take_step();
  [[noreturn]] void end_diverged();
  void validate();
  double judge(const ValidationResult& result);
  void log_row();
  double rate_of(int64_t step) const;
  // trainer_checkpoints.cpp
  void check_best(TrainingState& state);
  void write_checkpoint();
  bool save();
  void save_at_end();
  void rescue();
  TrainingState load_last_good();
  void go_back();

  ProcessGroup alone_;
  ProcessGroup& group_;
  const std::chrono::steady_clock::time_point start_;
  TrainConfig config_;
  std::filesystem::path run_;
  TrainingSet training_set_;
  Validation validation_;
  CheckpointFolder checkpoints_;
  Loss loss_;  // of frames, which validates
  ClipLoss clip_loss_;
  KernelProbe kernel_probe_;
  std::shared_ptr<Network> network_;
  Optimizer optimizer_;
  RunCourse course_;
  std::optional<RunLock> lock_;        // of rank 0
  std::optional<RunLog> log_;          // of rank 0
  std::map<std::string, double> row_;  // scores of a validation that are not logged yet
  StepTimer timer_;                    // since the last row of the log
  std::string verdict_;
};

}  // namespace ld
