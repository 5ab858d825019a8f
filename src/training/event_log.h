// metrics.csv of a run: one row each time something was measured; a resumed run continues it without gaps or
// repeats.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace ld {

class EventLog {
 public:
  /// Continues an existing file, without the rows behind `step` (of steps that a resumed run does again).
  EventLog(std::filesystem::path path, std::vector<std::string> columns, int64_t step);

  /// Columns without a value stay empty. The first column is the step.
  void write(int64_t step, const std::map<std::string, double>& values);

 private:
  std::filesystem::path path_;
  std::vector<std::string> columns_;
};

}  // namespace ld
