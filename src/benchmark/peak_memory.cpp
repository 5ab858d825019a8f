#include "benchmark/peak_memory.h"

#include <malloc.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

#include "core/error.h"
#include "ops/memory_pool.h"

namespace ld {
namespace {

constexpr const char* kStatus = "/proc/self/status";
constexpr const char* kClear = "/proc/self/clear_refs";

/// A line "VmRSS:   1234 kB" of the process's status, in MB.
double status_mb(const std::string& key) {
  std::ifstream status(kStatus);
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(key + ":", 0) != 0) continue;
    std::istringstream words(line.substr(key.size() + 1));
    double kilobytes = 0;
    words >> kilobytes;
    return kilobytes * 1024 / 1e6;
  }
  fail("{} has no line {}; peak memory cannot be measured on this system", kStatus, key);
}

}  // namespace

double resident_memory_mb() {
  return status_mb("VmRSS");
}

double peak_memory_mb(const std::function<void()>& work) {
  release_memory_pool();
  malloc_trim(0);
  std::ofstream clear(kClear);
  clear << 5 << std::flush;  // proc(5): "reset the peak resident set size"
  if (!clear) fail("cannot write to {}; peak memory cannot be measured on this system", kClear);
  const double before = status_mb("VmRSS");
  work();
  return std::max(status_mb("VmHWM") - before, 0.0);
}

}  // namespace ld
