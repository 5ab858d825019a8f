#include "ops/generated_filter.h"

#include <algorithm>

#include "ops/check.h"
#include "ops/kernel_gather.h"
#include "ops/kernel_splat.h"

namespace ld {
namespace {

using torch::Tensor;

constexpr int64_t kLogitBytes = int64_t(256) << 20;  // of kernel logits that exist at a time

Tensor rows(const Tensor& t, int64_t first, int64_t last) {
  return t.narrow(t.dim() - 2, first, last - first);
}

/// Calls filter(logits, log_n, values) for strips of rows, widened by the reach of the kernel, whose logits
/// fit in kLogitBytes; for all rows at once where a gradient is kept.
template <class Filter>
Tensor in_strips(const FullyConnectedWeights& generator, const Tensor& x, const Tensor& shared,
                 const Tensor& log_n, const Tensor& values, const Filter& filter) {
  const int64_t taps = generator.weights.back().size(0), height = x.size(3);
  const int64_t radius = expect_odd_kernel("generated filter", taps) / 2;
  const int64_t row_bytes =
      std::max<int64_t>(x.size(0) * x.size(1) * taps * x.size(4) * int64_t(x.element_size()), 1);
  const int64_t step = at::GradMode::is_enabled() ? height : std::max<int64_t>(kLogitBytes / row_bytes, 16);
  std::vector<Tensor> strips;
  for (int64_t begin = 0; begin < height; begin += step) {
    const int64_t end = std::min(begin + step, height);
    const int64_t first = std::max<int64_t>(begin - radius, 0), last = std::min(end + radius, height);
    const Tensor logits = fully_connected(rows(x, first, last), rows(shared, first, last), generator, false);
    strips.push_back(rows(filter(logits, rows(log_n, first, last), rows(values, first, last)), begin - first,
                          end - first));
  }
  return strips.size() == 1 ? strips[0] : at::cat(strips, strips[0].dim() - 2);
}

}  // namespace

Tensor generated_splat(const FullyConnectedWeights& generator, const Tensor& x, const Tensor& shared,
                       const Tensor& log_n, const Tensor& values) {
  return in_strips(generator, x, shared, log_n, values, kernel_splat);
}

Tensor generated_splat_joint(const FullyConnectedWeights& generator, const Tensor& x, const Tensor& shared,
                             const Tensor& log_n, const Tensor& values) {
  return in_strips(generator, x, shared, log_n, values, kernel_splat_joint);
}

Tensor generated_gather(const FullyConnectedWeights& generator, const Tensor& x, const Tensor& shared,
                        const Tensor& log_n, const Tensor& values) {
  return in_strips(generator, x, shared, log_n, values,
                   [](const Tensor& logits, const Tensor& given, const Tensor& v) {
                     return kernel_gather(logits.squeeze(1), given, v);
                   });
}

}  // namespace ld
