#include "models/network_input.h"

#include <limits>

#include "core/error.h"
#include "frame/half_range.h"
#include "frame/schema.h"
#include "ops/expect_tensor.h"

namespace ld {

using torch::Tensor;

namespace {

/// Whether all numbers lie in [low, high]; NaN does not.
bool lies_within(const Tensor& t, double low, double high) {
  const auto [least, largest] = at::aminmax(t.detach());
  return least.item<double>() >= low && largest.item<double>() <= high;
}

int64_t count(const Tensor& mask) {
  return mask.sum().item<int64_t>();
}

}  // namespace

void check_input(const NetworkInput& input, const NetworkConfig& config) {
  const auto type = floating_type("network: features", input.features);
  expect_tensor("network: features", "[B, S, F, H, W]", input.features,
                {kAnySize, kAnySize, channel_count(config.features), kAnySize, kAnySize}, type);
  const auto sizes = input.features.sizes();
  if (sizes[1] == 0)
    fail("network: the input has 0 samples a pixel (features of shape [B, 0, F, H, W]), expected at least 1");
  if (input.features.numel() == 0) fail("network: features are empty, expected at least one pixel");
  expect_tensor("network: radiance", "[B, S, 3, H, W]", input.radiance,
                {sizes[0], sizes[1], 3, sizes[3], sizes[4]}, type);
  expect_tensor("network: valid", "[B, S, 1, H, W]", input.valid, {sizes[0], sizes[1], 1, sizes[3], sizes[4]},
                type);
}

NetworkInput sanitise(NetworkInput input, InputFaults& faults) {
  faults = {};
  input.valid = input.valid.detach();
  const double largest_radiance = input.radiance.scalar_type() == torch::kFloat32
                                      ? double(std::numeric_limits<float>::max())
                                      : std::numeric_limits<double>::max();
  const bool features_fit = lies_within(input.features, -kHalfMax, kHalfMax);
  const bool radiance_fits = lies_within(input.radiance, 0, largest_radiance);
  if (features_fit && radiance_fits) return input;

  const Tensor finite = input.features.detach()
                            .isfinite()
                            .all(2, /*keepdim=*/true)
                            .logical_and(input.radiance.detach().isfinite().all(2, true));
  const Tensor bad = finite.logical_not();
  faults.not_finite = count(bad.logical_and(input.valid.ne(0)));
  input.features = input.features.masked_fill(bad, 0);
  input.radiance = input.radiance.masked_fill(bad, 0);
  input.valid = input.valid.masked_fill(bad, 0);

  const Tensor drawn = input.valid.ne(0);
  faults.negative = count(input.radiance.detach().lt(0).logical_and(drawn));
  faults.clamped = count(input.features.detach().abs().gt(kHalfMax).logical_and(drawn));
  input.radiance = input.radiance.clamp_min(0);
  input.features = input.features.clamp(-kHalfMax, kHalfMax);
  return input;
}

}  // namespace ld
