#include "models/sample_statistics.h"

#include "models/row_strips.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

namespace {

Tensor statistics(const Tensor& features, const Tensor& valid) {
  const Tensor mean = masked_mean(features, valid);
  const Tensor rest = features - mean.unsqueeze(1);
  // The mean of many large values is rounded; what it misses is the mean of the rest.
  const Tensor missed = masked_mean(rest, valid);
  return at::cat({mean + missed, masked_mean((rest - missed.unsqueeze(1)).square(), valid)}, 1).unsqueeze(1);
}

}  // namespace

Tensor sample_statistics(const Tensor& features, const Tensor& valid) {
  const int64_t row_bytes = 3 * features.size(0) * features.size(1) * features.size(2) * features.size(4) *
                            int64_t(features.element_size());
  return in_strips(features.size(3), short_strip_rows(features.size(3), row_bytes),
                   [&](int64_t begin, int64_t end) {
                     return statistics(rows(features, begin, end), rows(valid, begin, end));
                   });
}

}  // namespace ld
