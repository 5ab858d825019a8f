#include "training/run/collapse_watch.h"

#include <algorithm>
#include <cmath>

namespace ld {
namespace {

constexpr size_t kRemembered = 20;  // calm windows
constexpr size_t kToJudge = 4;      // with fewer, the training has only begun

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

double usual_loss(const WatchState& state) {
  return state.medians.size() < kToJudge ? 0 : median(state.medians);
}

bool watch_loss(WatchState& state, const WatchConfig& config, double loss, int64_t step) {
  if (!std::isfinite(loss)) return false;
  state.losses.push_back(loss);
  if (static_cast<int64_t>(state.losses.size()) < config.window) return false;
  const double now = median(state.losses), usual = usual_loss(state);
  state.losses.clear();
  if (usual > 0 && now > config.loss_factor * usual) {
    ++state.raised;
  } else {
    state.raised = 0;
    state.medians.push_back(now);
    if (state.medians.size() > kRemembered) state.medians.erase(state.medians.begin());
    state.calm_step = state.window_begin;
  }
  state.window_begin = step;
  return state.raised >= config.patience;
}

}  // namespace ld
