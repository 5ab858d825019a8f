#include "ops/partition.h"

#include "ops/check.h"
#include "ops/composition.h"

namespace ld {

using torch::Tensor;

Partition partition(const Tensor& logits, const Tensor& valid, const Tensor& radiance,
                    const Tensor& embedding, Compositing compositing) {
  const auto type = floating_type("partition: logits", logits);
  expect_tensor("partition: logits", "[B, S, N, H, W]", logits,
                {kAnySize, kAnySize, kAnySize, kAnySize, kAnySize}, type);
  const int64_t batch = logits.size(0), samples = logits.size(1), height = logits.size(3),
                width = logits.size(4);
  expect_tensor("partition: valid", "[B, S, 1, H, W]", valid, {batch, samples, 1, height, width}, type);
  expect_tensor("partition: radiance", "[B, S, 3, H, W]", radiance, {batch, samples, 3, height, width}, type);
  expect_tensor("partition: embedding", "[B, S, E, H, W]", embedding,
                {batch, samples, kAnySize, height, width}, type);
  return composed::partition(logits, valid.detach(), radiance, embedding, compositing);
}

}  // namespace ld
