// Checkpoints of a run as folders RUN/checkpoints/step_00000500, free of LibTorch: how they come to be there
// whole or not at all, which are kept, and which one a run continues from. What the files hold is
// training/checkpoint.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace ld {

class CheckpointFolder {
 public:
  /// Keeps the `keep` newest checkpoints and the best.
  CheckpointFolder(const std::filesystem::path& run, int64_t keep);

  /// Calls fill(folder), which writes kCheckpointFiles (weights/checkpoint_files.h) into a folder beside,
  /// adds the checksums, flushes all to the disk, renames it, and makes the link `last` name it, and
  /// `best`, too, if it is; then removes what need not be kept. A process that is killed at any time leaves
  /// whole checkpoints. Throws Error when the disk is full or the folder cannot be written: all older
  /// checkpoints are then still there.
  void write(int64_t step, const std::function<void(const std::filesystem::path&)>& fill, bool best);

  /// The newest whole checkpoint, which `last` names from now on. A newer one that is damaged is reported and
  /// set aside under the name damaged_step_...; nullopt when there never was a checkpoint. Throws Error
  /// naming what is wrong with each when there are some and none is whole.
  std::optional<std::filesystem::path> newest_whole();

  /// Makes `best` name the checkpoint of this step, and reports it when it named another. False when that
  /// checkpoint is missing or damaged, which is reported, too; `best` then stays as it was.
  bool restore_best(int64_t step);

  /// The newest whole checkpoint of at most `step` steps.
  std::optional<std::filesystem::path> newest_whole_until(int64_t step) const;

  /// Forgets all that came after `step`, of which there is a checkpoint, or, with 0, everything: a run goes
  /// on from there. A process that is killed meanwhile leaves a run that continues from some checkpoint.
  void go_back_to(int64_t step);

  bool holds(int64_t step) const;

  /// Whether a run has ever saved here.
  bool begun() const;

 private:
  std::vector<std::string> names() const;  // newest first
  void remove_surplus() const;
  void bring_back_replaced() const;

  std::filesystem::path folder_;
  int64_t keep_;
};

/// Throws Error saying what is wrong with a checkpoint: a file is missing or does not match its checksum.
void verify_checkpoint(const std::filesystem::path& checkpoint);

}  // namespace ld
