#include "ops/kernel_gather.h"

#include "ops/check.h"
#include "ops/composition.h"
#include "ops/finite_sources.h"

namespace ld {

using torch::Tensor;

Tensor kernel_gather(const Tensor& logits, const Tensor& log_n, const Tensor& values) {
  const auto type = floating_type("kernel_gather: logits", logits);
  expect_tensor("kernel_gather: logits", "[B, K*K, H, W]", logits, {kAnySize, kAnySize, kAnySize, kAnySize},
                type);
  expect_odd_kernel("kernel_gather", logits.size(1));
  const int64_t batch = logits.size(0), height = logits.size(2), width = logits.size(3);
  expect_tensor("kernel_gather: log_n", "[B, H, W]", log_n, {batch, height, width}, type);
  expect_tensor("kernel_gather: values", "[B, C, H, W]", values, {batch, kAnySize, height, width}, type);
  const FiniteSources sources = finite_sources(log_n.detach(), values);
  return unscaled(composed::kernel_gather(logits, sources.log_n, sources.values), sources);
}

}  // namespace ld
