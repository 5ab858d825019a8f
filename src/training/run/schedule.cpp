#include "training/run/schedule.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/pi.h"

namespace ld {
namespace {

/// From `from` to `to` along half a cosine; `progress` is clamped to [0, 1].
double along_cosine(double from, double to, double progress) {
  return to + 0.5 * (from - to) * (1 + std::cos(kPi * std::clamp(progress, 0.0, 1.0)));
}

/// As PyTorch's OneCycleLR with pct_start `rise`, div_factor 1 / start and final_div_factor start / end; its
/// cycle of Adam's beta1 is left out. Divided as there, so that the defaults give the same bits.
double one_cycle(const OneCycleConfig& config, double highest, double step, double total_steps) {
  const double first = highest / (1 / config.start), last = first / (config.start / config.end);
  const double top = std::max(config.rise * total_steps - 1, 0.0);
  if (step < top) return along_cosine(first, highest, step / top);
  return along_cosine(highest, last, (step - top) / std::max(total_steps - 1 - top, 1.0));
}

double scheduled_rate(const OptimizerConfig& config, int64_t step, double epoch, int64_t total_steps) {
  const double rate = config.learning_rate;
  const auto now = static_cast<double>(step), end = static_cast<double>(total_steps);
  if (config.schedule == "step") {
    return rate * std::pow(config.step_factor, std::floor(epoch / static_cast<double>(config.step_epochs)));
  }
  if (config.schedule == "inverse_root") {
    if (epoch < config.ramp_epochs) return rate * std::pow(config.ramp_start, 1 - epoch / config.ramp_epochs);
    return rate * std::sqrt(config.ramp_epochs / epoch);
  }
  if (config.schedule == "cosine") return along_cosine(rate, 0, now / end);
  if (config.schedule == "one_cycle") return one_cycle(config.one_cycle, rate, now, end);
  return rate;
}

}  // namespace

double learning_rate(const OptimizerConfig& config, int64_t step, double epoch, int64_t total_steps) {
  const double rate = scheduled_rate(config, step, epoch, total_steps);
  if (step >= config.warmup_steps) return rate;
  return rate * static_cast<double>(step + 1) / static_cast<double>(config.warmup_steps);
}

int64_t schedule_steps(const TrainConfig& config, int64_t batches_per_epoch) {
  if (config.steps > 0 || config.run.minutes > 0) return config.steps;
  return std::max<int64_t>(config.epochs * batches_per_epoch / config.optimizer.accumulate, 1);
}

void check_optimizer(const OptimizerConfig& config) {
  if (config.name != "adamw" && config.weight_decay > 0)
    fail_usage(
        "optimizer.weight_decay is {:g}, but optimizer.name is {}, which has none; set optimizer.name=adamw "
        "or "
        "optimizer.weight_decay=0",
        config.weight_decay, config.name);
  if (config.schedule == "one_cycle" && config.warmup_steps > 0)
    fail_usage(
        "optimizer.warmup_steps is {}, but schedule one_cycle begins with a rise of its own; set "
        "optimizer.warmup_steps=0 or choose another schedule",
        config.warmup_steps);
}

}  // namespace ld
