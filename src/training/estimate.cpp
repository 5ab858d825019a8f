#include "training/estimate.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>

#include "core/progress.h"
#include "training/optimizer/optimizer.h"

namespace ld {
namespace {

constexpr double kLongPass = 10;  // seconds, after which a second one is not worth it

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double largest_size_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;
}

double megabytes(uint64_t bytes) {
  return static_cast<double>(bytes) / 1e6;
}

/// Returns when a device that works by itself has done all that it was given: whoever reads a number waits.
void wait_for_device(const torch::Tensor& result) {
  if (!result.is_cpu()) result.detach().flatten()[0].cpu();
}

}  // namespace

BatchCost measure_batch(Network& network, const Loss& loss, const Batch& batch,
                        const std::function<bool()>& stop) {
  BatchCost cost;
  for (int pass = 0; pass < 2 && !stop(); ++pass) {
    const double start = now();
    const torch::Tensor denoised = network.forward(batch.input);
    wait_for_device(denoised);
    const double forward = now() - start;
    loss(denoised, batch.reference).backward();
    wait_for_device(denoised);
    const double seconds = now() - start;
    const int64_t pixels = batch.reference.numel() / 3;
    const double per_pixel = forward / static_cast<double>(pixels);
    if (pass == 0 || seconds < cost.seconds) cost.seconds = seconds;
    if (pass == 0 || per_pixel < cost.seconds_per_pixel) cost.seconds_per_pixel = per_pixel;
    forget_gradients(network);
    if (seconds > kLongPass) break;
  }
  cost.megabytes = largest_size_mb();
  return cost;
}

std::string time_text(const Plan& plan) {
  const double step = plan.batch.seconds * static_cast<double>(plan.accumulate);
  const double validation = plan.batch.seconds_per_pixel * static_cast<double>(plan.validation_pixels) *
                            static_cast<double>(plan.validations);
  const auto steps = static_cast<double>(plan.steps);
  const double all = step * steps + validation;
  std::string text =
      fmt::format("estimate: {} steps of {:.3g} s and {} validations: {}; memory {:.0f} MB", plan.steps, step,
                  plan.validations, duration_text(all), plan.batch.megabytes + plan.state_megabytes);
  if (plan.max_minutes > 0 && all > 60 * plan.max_minutes)
    text += fmt::format("; run.max_minutes={:g} ends it after about {:.0f} steps", plan.max_minutes,
                        60 * plan.max_minutes / std::max(all, 1e-9) * steps);
  return text;
}

std::string disk_text(const Plan& plan) {
  return fmt::format("estimate: up to {} checkpoints of {:.1f} MB: {:.1f} MB of the {:.0f} MB free",
                     plan.checkpoints, megabytes(plan.checkpoint_bytes),
                     megabytes(plan.checkpoint_bytes) * static_cast<double>(plan.checkpoints),
                     megabytes(plan.free_bytes));
}

bool fits_on_disk(const Plan& plan) {
  return plan.checkpoint_bytes * static_cast<uint64_t>(plan.checkpoints) <= plan.free_bytes;
}

}  // namespace ld
