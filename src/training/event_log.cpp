#include "training/event_log.h"

#include <fmt/ranges.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "core/error.h"
#include "core/file_io.h"

namespace ld {

EventLog::EventLog(std::filesystem::path path, std::vector<std::string> columns, int64_t step)
    : path_(std::move(path)), columns_(std::move(columns)) {
  std::string kept = fmt::format("step,{}\n", fmt::join(columns_, ","));
  if (std::filesystem::exists(path_)) {
    std::istringstream lines(read_file(path_));
    std::string line;
    std::getline(lines, line);  // the header, written anew
    while (std::getline(lines, line))
      if (std::atoll(line.c_str()) <= step) kept += line + "\n";
  }
  write_file_atomically(path_, kept);
}

void EventLog::write(int64_t step, const std::map<std::string, double>& values) {
  std::string line = fmt::format("{}", step);
  for (const std::string& column : columns_) {
    const auto found = values.find(column);
    line += found == values.end() ? "," : fmt::format(",{:.7g}", found->second);
  }
  std::ofstream file(path_, std::ios::app);
  file << line << "\n" << std::flush;
  if (!file) fail("cannot append to {}; is the disk full?", path_.string());
}

}  // namespace ld
