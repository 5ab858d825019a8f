// A table of a run that grows by a row each time something was measured (metrics.csv, timing.csv); a resumed
// run continues it without gaps or repeats.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace ld {

class EventLog {
 public:
  /// Continues an existing file, without the rows behind `step` (of steps that a resumed run does again). One
  /// that an earlier program wrote with other columns is renamed (metrics.1.csv), and a new one begun.
  EventLog(std::filesystem::path path, std::vector<std::string> columns, int64_t step);

  /// Columns without a value stay empty. The first column is the step. Rows that find no room on the disk are
  /// reported once, kept in memory and written with a later one.
  void write(int64_t step, const std::map<std::string, double>& values);

  /// Brings all rows to the disk itself; false when some still wait for room.
  bool flush();

 private:
  bool append();

  std::filesystem::path path_;
  std::vector<std::string> columns_;
  std::string waiting_;
  bool reported_ = false;
};

}  // namespace ld
