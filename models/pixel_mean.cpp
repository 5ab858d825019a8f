#include "models/pixel_mean.h"

#include "models/exposure.h"
#include "ops/weighted_sum.h"

namespace ld {

NetworkInput pixel_mean(NetworkInput input, const NetworkConfig& config) {
  input.features = masked_mean(input.features, input.valid).unsqueeze(1);
  input.radiance = masked_mean(input.radiance, input.valid).unsqueeze(1);
  input.valid = input.valid.ne(0).any(1, /*keepdim=*/true).to(input.valid.scalar_type());
  // Before the input is moved: the order of a call's arguments is the compiler's choice.
  const torch::Tensor exposure = torch::ones({input.features.size(0)}, torch::kFloat64);
  return with_exposure(std::move(input), exposure, config);
}

}  // namespace ld
