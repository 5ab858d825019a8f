// What a run writes down while it trains: metrics.csv and timing.csv for programs, TensorBoard's event files
// for the eye.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "training/run/event_log.h"
#include "training/run/tensorboard.h"
#include "training/validation.h"

namespace ld {

class RunLog {
 public:
  /// Continues the files of a run after `step`; `layers`: those of its network; `sequences`: whether its
  /// validation measures them.
  RunLog(const std::filesystem::path& run, int64_t step, int64_t layers, bool sequences = false);

  /// metrics.csv gets the values, which depend on configuration, data and step alone (an interrupted run has
  /// the same bytes as one that was not); timing.csv the seconds.
  void row(int64_t step, const std::map<std::string, double>& values, double seconds_per_step);

  void pictures(int64_t step, const std::vector<ValidationPicture>& pictures);

  void strip(int64_t step, const SequenceStrip& strip);

  /// All rows to the disk itself, as far as there is room.
  void flush();

 private:
  template <class Write>
  void show(const Write& write);

  EventLog metrics_, timing_;
  EventFile board_;
  bool board_reported_ = false, inputs_shown_ = false;
};

}  // namespace ld
