#include "training/run/event_log.h"

#include <fcntl.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "core/error.h"
#include "core/file_io.h"
#include "core/log.h"

namespace ld {

namespace {

/// metrics.csv becomes metrics.1.csv, or .2 where there is one.
void set_aside(const std::filesystem::path& path) {
  std::filesystem::path aside;
  for (int number = 1; aside.empty() || std::filesystem::exists(aside); ++number)
    aside =
        path.parent_path() / fmt::format("{}.{}{}", path.stem().string(), number, path.extension().string());
  std::filesystem::rename(path, aside);
  spdlog::info("{} has other columns than this program writes: its rows are in {} from now on", path.string(),
               aside.filename().string());
}

}  // namespace

EventLog::EventLog(std::filesystem::path path, std::vector<std::string> columns, int64_t step)
    : path_(std::move(path)), columns_(std::move(columns)) {
  const std::string header = fmt::format("step,{}", fmt::join(columns_, ","));
  std::string kept = header + "\n";
  if (std::filesystem::exists(path_)) {
    std::istringstream lines(read_file(path_));
    std::string line;
    std::getline(lines, line);
    if (line != header)
      set_aside(path_);
    else
      while (std::getline(lines, line))
        if (std::atoll(line.c_str()) <= step) kept += line + "\n";
  }
  write_file_atomically(path_, kept);
}

void EventLog::write(int64_t step, const std::map<std::string, double>& values) {
  waiting_ += fmt::format("{}", step);
  for (const std::string& column : columns_) {
    const auto found = values.find(column);
    waiting_ += found == values.end() ? "," : fmt::format(",{:.9g}", found->second);
  }
  waiting_ += "\n";
  append();
}

bool EventLog::append() {
  if (waiting_.empty()) return true;
  const int file = open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  const off_t before = file < 0 ? -1 : lseek(file, 0, SEEK_END);
  size_t done = 0;
  while (before >= 0 && done < waiting_.size()) {
    const ssize_t written = ::write(file, waiting_.data() + done, waiting_.size() - done);
    if (written <= 0) break;
    done += static_cast<size_t>(written);
  }
  const int reason = errno;
  const bool whole = done == waiting_.size();
  // Half a row would spoil the table.
  const bool clean = whole || before < 0 || ftruncate(file, before) == 0;
  if (file >= 0) close(file);
  if (whole) {
    waiting_.clear();
    reported_ = false;
  } else if (!reported_) {
    spdlog::warn("cannot append to {}: {}; its rows are kept and written when there is room{}",
                 path_.string(), std::strerror(reason), clean ? "" : " (half a row may stay behind)");
    reported_ = true;
  }
  return whole;
}

bool EventLog::flush() {
  if (!append()) return false;
  flush_to_disk(path_);
  return true;
}

}  // namespace ld
