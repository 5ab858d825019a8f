#include "models/sample_statistics.h"

#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

Tensor sample_statistics(const Tensor& features, const Tensor& valid) {
  const Tensor mean = masked_mean(features, valid);
  const Tensor rest = features - mean.unsqueeze(1);
  // The mean of many large values is rounded; what it misses is the mean of the rest.
  const Tensor missed = masked_mean(rest, valid);
  return at::cat({mean + missed, masked_mean((rest - missed.unsqueeze(1)).square(), valid)}, 1).unsqueeze(1);
}

}  // namespace ld
