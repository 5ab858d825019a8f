#include "core/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace ld {
namespace {

constexpr double kPatience = 2;  // seconds of work before anything is shown

}  // namespace

std::string duration_text(double seconds) {
  const auto s = static_cast<int64_t>(std::llround(std::max(0.0, seconds)));
  if (s >= 3600) return fmt::format("{}h{:02}m", s / 3600, s / 60 % 60);
  if (s >= 60) return fmt::format("{}m{:02}s", s / 60, s % 60);
  return fmt::format("{}s", s);
}

Progress::Progress(std::string label, int64_t total, int64_t done)
    : label_(std::move(label)),
      total_(total),
      done_(done),
      done_before_(done),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()),
      printed_(start_) {}

Progress::~Progress() {
  if (terminal_ && shown_) std::fputc('\n', stderr);
}

void Progress::advance(int64_t steps, const std::string& note) {
  const std::lock_guard<std::mutex> lock(mutex_);
  done_ += steps;
  const auto now = std::chrono::steady_clock::now();
  const double since = std::chrono::duration<double>(now - printed_).count();
  if (std::chrono::duration<double>(now - start_).count() < kPatience) return;
  const bool last = done_ >= total_;
  if (!last && since < (terminal_ ? 0.1 : 10.0)) return;
  printed_ = now;
  shown_ = true;
  print(note, last);
}

void Progress::print(const std::string& note, bool last) {
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double rate = static_cast<double>(done_ - done_before_) / std::max(elapsed, 1e-9);
  const double left = static_cast<double>(total_ - done_) / std::max(rate, 1e-9);
  std::string line = fmt::format("{} {}/{}", label_, done_, total_);
  if (terminal_) {
    const auto filled = static_cast<size_t>(24 * done_ / std::max<int64_t>(total_, 1));
    line +=
        fmt::format(" [{}{}]", std::string(filled, '='), std::string(24 - std::min<size_t>(filled, 24), ' '));
  }
  line += last ? fmt::format(", {} in all", duration_text(elapsed))
               : fmt::format(", {} left", duration_text(left));
  if (!note.empty()) line += ", " + note;
  // \r and "erase to the end of the line" redraw in place; both would be noise in a file.
  fmt::print(stderr, "{}{}{}", terminal_ ? "\r" : "", line, terminal_ ? "\x1b[K" : "\n");
  std::fflush(stderr);
}

}  // namespace ld
