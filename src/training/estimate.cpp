#include "training/estimate.h"

#include <algorithm>
#include <chrono>

#include "core/process/process_memory.h"
#include "core/progress.h"
#include "ops/memory_pool.h"
#include "training/optimizer/optimizer.h"

namespace ld {
namespace {

constexpr double kLongPass = 10;  // seconds, after which a second one is not worth it
constexpr int kPieceSide = 512;   // of a validation frame that is measured

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double megabytes(double bytes) {
  return bytes / 1e6;
}

/// Returns when a device that works by itself has done all that it was given: whoever reads a number waits.
void wait_for_device(const torch::Tensor& result) {
  if (!result.is_cpu()) result.detach().flatten()[0].cpu();
}

/// Two passes, or one that takes long or is followed by a stop; the seconds of the faster.
double fastest_pass(const std::function<bool()>& stop, const std::function<void()>& pass) {
  double fastest = 0;
  for (int i = 0; i < 2 && !stop() && fastest <= kLongPass; ++i) {
    const double start = now();
    pass();
    const double seconds = now() - start;
    fastest = i == 0 ? seconds : std::min(fastest, seconds);
  }
  return fastest;
}

}  // namespace

BatchCost measure_batch(Network& network, const ClipLoss& loss, const ClipPassOptions& pass_options,
                        const Batch& batch, const std::function<bool()>& stop) {
  BatchCost cost;
  cost.seconds = fastest_pass(stop, [&] {
    add_gradient(network, batch, loss, 1, pass_options);
    forget_gradients(network);
  });
  cost.megabytes = megabytes(static_cast<double>(peak_resident_bytes()));
  return cost;
}

ValidationCost measure_validation(Network& network, const Validation& validation,
                                  const std::function<bool()>& stop) {
  ValidationCost cost;
  const torch::NoGradGuard no_graph;
  release_memory_pool();
  const int64_t before = memory_pool_state().live;
  int64_t pixels = 1;
  cost.seconds_per_pixel = fastest_pass(stop, [&] {
    Batch batch = validation.middle_of_largest(network.config().features, kPieceSide);
    pixels = batch.reference.numel() / 3;
    wait_for_device(network.forward(std::move(batch.input)));
  });
  cost.seconds_per_pixel /= static_cast<double>(pixels);
  const double times = static_cast<double>(validation.pixels_of_largest()) / static_cast<double>(pixels);
  cost.megabytes = megabytes(static_cast<double>(validation.picture_bytes()) +
                             times * static_cast<double>(memory_pool_state().peak_live - before));
  release_memory_pool();
  cost.megabytes += megabytes(static_cast<double>(resident_bytes()));
  return cost;
}

double memory_megabytes(const Plan& plan) {
  return std::max(plan.batch.megabytes, plan.validation.megabytes) + plan.state_megabytes;
}

bool fits_in_memory(const Plan& plan) {
  return plan.available_megabytes <= 0 || memory_megabytes(plan) <= plan.available_megabytes;
}

std::string time_text(const Plan& plan) {
  const double step = plan.batch.seconds * static_cast<double>(plan.accumulate);
  const double validation = plan.validation.seconds_per_pixel * static_cast<double>(plan.validation_pixels) *
                            static_cast<double>(plan.validations);
  const auto steps = static_cast<double>(plan.steps);
  const double all = step * steps + validation;
  std::string text =
      fmt::format("estimate: {} steps of {:.3g} s and {} validations: {}; memory {:.0f} MB{}", plan.steps,
                  step, plan.validations, duration_text(all), memory_megabytes(plan),
                  plan.validation.megabytes > plan.batch.megabytes ? " when validating" : "");
  if (plan.max_minutes > 0 && all > 60 * plan.max_minutes)
    text += fmt::format("; run.max_minutes={:g} ends it after about {:.0f} steps", plan.max_minutes,
                        60 * plan.max_minutes / std::max(all, 1e-9) * steps);
  return text;
}

std::string disk_text(const Plan& plan) {
  return fmt::format(
      "estimate: up to {} checkpoints of {:.1f} MB: {:.1f} MB of the {:.0f} MB free", plan.checkpoints,
      megabytes(static_cast<double>(plan.checkpoint_bytes)),
      megabytes(static_cast<double>(plan.checkpoint_bytes)) * static_cast<double>(plan.checkpoints),
      megabytes(static_cast<double>(plan.free_bytes)));
}

bool fits_on_disk(const Plan& plan) {
  return plan.checkpoint_bytes * static_cast<uint64_t>(plan.checkpoints) <= plan.free_bytes;
}

}  // namespace ld
