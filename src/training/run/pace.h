// How many steps there is time for: a run with run.minutes has a schedule that ends when the time does.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace ld {

/// What the parts of a run take, and how often each comes. Seconds.
struct Pace {
  double step = 0;        // loading and accumulation included
  double first_step = 0;  // of the first `first_steps`, whose frames are read for the first time
  int64_t first_steps = 0;
  double validation = 0, checkpoint = 0;
  int64_t validate_every = 1, checkpoint_every = 1;  // steps
};

/// All steps, validations and checkpoints of a run; each validation may be the best, and is saved then.
double seconds_of(const Pace& pace, int64_t steps);

/// The most steps that end within so many seconds, at least 1.
int64_t steps_within(const Pace& pace, double seconds);

/// The mean of the middle half of the measurements, of which there must be one. What else the machine did at
/// times changes it little, and so does a loader that delivers several batches at once.
double typical(std::vector<double> seconds);

/// Since a moment of the clock that does not jump.
inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// What a step takes on average, with all that lies between it and the next.
class StepTimer {
 public:
  void start() {
    steps_ = 0;
    since_ = std::chrono::steady_clock::now();
  }
  void count_step() { ++steps_; }
  /// Since start(); where no step was counted, all of the time since then.
  double seconds_per_step() const {
    return seconds_since(since_) / static_cast<double>(steps_ > 0 ? steps_ : 1);
  }

 private:
  int64_t steps_ = 0;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
};

/// One line for people.
std::string pace_text(const Pace& pace, double minutes, int64_t steps);

}  // namespace ld
