// What a run folder says about its run: the resolved configuration, and what it was made with.
#pragma once

#include <filesystem>
#include <string>

#include "training/run/config.h"

namespace ld {

/// What may not change when a run continues, as YAML: everything but the sections `run:` (of which `minutes`
/// stays) and `watch:`, what only costs time or memory, and how the crops of a step are divided (data.batch,
/// optimizer.accumulate), whose product is compared with the checkpoint.
std::string fixed_configuration(TrainConfig config);

/// While a lock lives, no other process trains into that run folder. The lock of a process that dies is
/// released.
class RunLock {
 public:
  /// Makes the folder. Throws Error when another process holds it.
  explicit RunLock(const std::filesystem::path& run);
  ~RunLock();
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

 private:
  int descriptor_;
};

/// Writes the resolved configuration to RUN/config.yaml. Where there is one already, it must agree in
/// fixed_configuration(); UsageError names the first line that differs.
void claim_run_folder(const std::filesystem::path& run, const TrainConfig& config);

/// The `steps` of the folder's configuration; 0 when it has none, or there is no configuration.
int64_t stored_steps(const std::filesystem::path& run);

/// What made a run, besides its configuration.
struct RunOrigin {
  std::string command;   // as it was typed; "": not started from a command line
  std::string libtorch;  // its version
  std::string blas;      // OpenBLAS's name of its kernels; "": another BLAS
  int threads = 1, processes = 1;
  std::string dataset;  // data_checksum()
  int64_t parameters = 0, total_steps = 0;
};

/// Writes RUN/run.json: versions, threads, the command, and a line that does the run again.
void write_origin(const std::filesystem::path& run, const TrainConfig& config, const RunOrigin& origin);

/// The command that trains with the configuration of `run` again, into `out`.
std::string reproducing_command(const std::filesystem::path& run, const std::string& out, int threads);

/// An argument as a shell takes it.
std::string shell_word(const std::string& argument);

}  // namespace ld
