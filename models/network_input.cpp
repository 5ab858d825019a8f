#include "models/network_input.h"

#include <algorithm>

#include "core/error.h"
#include "frame/half_range.h"
#include "frame/schema.h"
#include "models/demodulation.h"
#include "models/exposure.h"
#include "models/pixel_mean.h"
#include "models/row_strips.h"
#include "ops/expect_tensor.h"

namespace ld {

using torch::Tensor;

namespace {

/// Whether all numbers lie in [low, high]; NaN does not.
bool lies_within(const Tensor& t, double low, double high) {
  const auto [least, largest] = at::aminmax(t.detach());
  return least.item<double>() >= low && largest.item<double>() <= high;
}

/// Of a mask [..., H, W] without its first rows.
int64_t count(const Tensor& mask, int64_t uncounted_rows) {
  return rows(mask, uncounted_rows, mask.size(-2)).sum().item<int64_t>();
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

NetworkInput sanitise(NetworkInput input, InputFaults& faults, int64_t uncounted_rows) {
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
  faults.not_finite = count(bad.logical_and(input.valid.ne(0)), uncounted_rows);
  input.features = input.features.masked_fill(bad, 0);
  input.radiance = input.radiance.masked_fill(bad, 0);
  input.valid = input.valid.masked_fill(bad, 0);

  const Tensor drawn = input.valid.ne(0);
  faults.negative = count(input.radiance.detach().lt(0).logical_and(drawn), uncounted_rows);
  faults.clamped = count(input.features.detach().abs().gt(kHalfMax).logical_and(drawn), uncounted_rows);
  input.radiance = input.radiance.clamp_min(0);
  input.features = input.features.clamp(-kHalfMax, kHalfMax);
  return input;
}

InputSource::Sizes WholeInput::sizes() const {
  const Tensor& features = input_.features;
  return {features.size(0), features.size(1), features.size(3), features.size(4),
          int64_t(features.element_size())};
}

NetworkInput WholeInput::rows(int64_t begin, int64_t end) const {
  if (begin == 0 && end == input_.features.size(3)) return input_;
  NetworkInput part = {ld::rows(input_.features, begin, end), ld::rows(input_.radiance, begin, end),
                       ld::rows(input_.valid, begin, end)};
  if (input_.demodulator.defined()) part.demodulator = ld::rows(input_.demodulator, begin, end);
  return part;
}

AdmittedInput::AdmittedInput(const InputSource& source, const NetworkConfig& config, InputFaults& faults)
    : source_(source), config_(config), faults_(faults) {
  const Sizes sizes = source.sizes();
  if (sizes.samples == 0 || sizes.batch * sizes.height * sizes.width == 0) {
    check_input(source.rows(0, sizes.height), config);
    fail("network: the input is empty, expected at least one sample and pixel");
  }
  faults = {};
  if (!config.exposure_normalisation) return;
  LogAverage average(sizes.batch);
  const int64_t row_bytes = sizes.batch * sizes.samples * sizes.width * 8 * 8;  // a few doubles a sample
  const int64_t step = short_strip_rows(sizes.height, row_bytes);
  for (int64_t begin = 0; begin < sizes.height; begin += step) {
    const NetworkInput strip = source.radiance_rows(begin, std::min(begin + step, sizes.height));
    average.add(strip.radiance, strip.valid);
  }
  exposure_ = average.exposure();
}

NetworkInput AdmittedInput::rows(int64_t begin, int64_t end) const {
  NetworkInput strip = source_.rows(begin, end);
  check_input(strip, config_);
  InputFaults found;
  strip = sanitise(std::move(strip), found, std::clamp<int64_t>(counted_rows_ - begin, 0, end - begin));
  counted_rows_ = std::max(counted_rows_, end);
  faults_.not_finite += found.not_finite;
  faults_.negative += found.negative;
  faults_.clamped += found.clamped;
  if (config_.means) strip = pixel_mean(std::move(strip), config_);
  if (exposure_.defined()) strip = with_exposure(std::move(strip), exposure_, config_);
  if (config_.demodulation != "none") {
    strip.demodulator = demodulator(strip.features, config_);
    strip.radiance = demodulated(strip.radiance, strip.demodulator);
  }
  return strip;
}

}  // namespace ld
