#include "training/run/pace.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace ld {
namespace {

constexpr int64_t kMostSteps = int64_t{1} << 40;

}  // namespace

double seconds_of(const Pace& pace, int64_t steps) {
  const int64_t first = std::min(steps, pace.first_steps);
  const int64_t validations = (steps + pace.validate_every - 1) / pace.validate_every;
  int64_t checkpoints = (steps + pace.checkpoint_every - 1) / pace.checkpoint_every;
  const bool together = pace.validate_every % pace.checkpoint_every == 0;
  if (pace.validation > 0 && !together) checkpoints += validations;
  return pace.first_step * static_cast<double>(first) + pace.step * static_cast<double>(steps - first) +
         pace.validation * static_cast<double>(validations) +
         pace.checkpoint * static_cast<double>(checkpoints);
}

int64_t steps_within(const Pace& pace, double seconds) {
  int64_t fits = 1, beyond = kMostSteps;
  while (beyond - fits > 1) {
    const int64_t middle = fits + (beyond - fits) / 2;
    (seconds_of(pace, middle) <= seconds ? fits : beyond) = middle;
  }
  return fits;
}

double typical(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  const auto quarter = static_cast<std::ptrdiff_t>(seconds.size() / 4);
  const auto begin = seconds.begin() + quarter, end = seconds.end() - quarter;
  return std::accumulate(begin, end, 0.0) / static_cast<double>(end - begin);
}

std::string pace_text(const Pace& pace, double minutes, int64_t steps) {
  return fmt::format(
      "run.minutes={:g}: a step takes {:.3g} s ({:.3g} s while frames are new), a validation {:.3g} s, a "
      "checkpoint {:.3g} s; so the schedule has {} steps",
      minutes, pace.step, pace.first_step, pace.validation, pace.checkpoint, steps);
}

}  // namespace ld
