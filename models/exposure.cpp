#include "models/exposure.h"

#include "frame/schema.h"
#include "models/log_luminance.h"
#include "ops/tone_map_tensor.h"

namespace ld {

using torch::Tensor;

Tensor exposure_of(const Tensor& radiance, const Tensor& valid) {
  const Tensor light = radiance.detach().to(torch::kFloat64).clamp_min(0);
  const Tensor good = valid.detach().ne(0).squeeze(2).logical_and(light.isfinite().all(2));  // [B, S, H, W]
  const Tensor light_of_samples = luminance(light.select(2, 0), light.select(2, 1), light.select(2, 2))
                                      .masked_fill(good.logical_not(), 0);
  const Tensor mean = (light_of_samples.sum(1) / good.sum(1).clamp_min(1)).cpu().contiguous();  // [B, H, W]
  const double* value = mean.data_ptr<double>();
  const Tensor exposure = torch::ones({mean.size(0)}, torch::kFloat64);
  for (int64_t b = 0; b < mean.size(0); ++b) {
    LogLuminance sum;
    for (int64_t p = 0; p < mean.size(1) * mean.size(2); ++p) sum.add(*value++);
    exposure[b] = sum.exposure();
  }
  return exposure;
}

NetworkInput with_exposure(NetworkInput input, const Tensor& exposure, const NetworkConfig& config) {
  const int64_t first = first_channel(config.features, "radiance");
  if (first < 0) return input;
  // In doubles: neither an exposure of 1e37 nor radiance of 3e38 leaves their range.
  const Tensor factor = exposure.to(input.radiance.device()).view({-1, 1, 1, 1, 1});
  const Tensor exposed = (input.radiance.detach().to(torch::kFloat64) * factor)
                             .clamp_max(kHalfMax)
                             .to(input.features.scalar_type());
  const Tensor seen = tone_map(exposed).masked_fill(input.valid.eq(0), 0);
  const int64_t channels = input.features.size(2);
  input.features = at::cat(
      {input.features.narrow(2, 0, first), seen, input.features.narrow(2, first + 3, channels - first - 3)},
      2);
  return input;
}

}  // namespace ld
