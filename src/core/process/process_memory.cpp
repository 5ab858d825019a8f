#include "core/process/process_memory.h"

#include <fstream>
#include <sstream>
#include <string>

#include "core/error.h"

namespace ld {
namespace {

constexpr const char* kClear = "/proc/self/clear_refs";

/// Of a line "VmRSS:   1234 kB" in such a file, in bytes; -1 where there is none.
int64_t bytes_of_line(const char* file, const std::string& key) {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(key + ":", 0) != 0) continue;
    std::istringstream words(line.substr(key.size() + 1));
    int64_t kilobytes = -1;
    return words >> kilobytes ? kilobytes * 1024 : -1;
  }
  return -1;
}

}  // namespace

int64_t resident_bytes() {
  return bytes_of_line("/proc/self/status", "VmRSS");
}

int64_t peak_resident_bytes() {
  return bytes_of_line("/proc/self/status", "VmHWM");
}

void reset_peak_resident() {
  std::ofstream clear(kClear);
  clear << 5 << std::flush;  // proc(5): "reset the peak resident set size"
  if (!clear) fail("cannot write to {}; peak memory cannot be measured on this system", kClear);
}

int64_t available_bytes() {
  return bytes_of_line("/proc/meminfo", "MemAvailable");
}

}  // namespace ld
