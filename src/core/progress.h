// Progress with the time left: a bar that redraws itself on a terminal, a plain line every few seconds
// otherwise. Work that is done in a moment shows none.
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace ld {

/// "1h02m", "3m20s", "7s".
std::string duration_text(double seconds);

class Progress {
 public:
  /// `done` is what an earlier run finished already; it does not count towards the speed.
  Progress(std::string label, int64_t total, int64_t done = 0);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Thread-safe. `note` stands behind the time left, for instance the current loss.
  void advance(int64_t steps = 1, const std::string& note = "");

 private:
  void print(const std::string& note, bool last);

  std::string label_;
  int64_t total_, done_, done_before_;
  bool terminal_, shown_ = false;
  std::chrono::steady_clock::time_point start_, printed_;
  std::mutex mutex_;
};

}  // namespace ld
