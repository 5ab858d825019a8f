#include "ops/partition.h"

#include <limits>

#include "ops/check.h"
#include "ops/weighted_sum.h"

namespace ld {
namespace {

using torch::Tensor;

/// log w_s^l of eq. 1, -inf for samples that do not count.
Tensor log_weights(const Tensor& logits, const Tensor& counted) {
  const double infinity = std::numeric_limits<double>::infinity();
  // Differences of logits beyond +-1e38 overflow; a quarter of the range leaves room for the sums that
  // follow.
  const double lowest = logits.scalar_type() == torch::kFloat32 ? std::numeric_limits<float>::lowest() / 4
                                                                : std::numeric_limits<double>::lowest() / 4;
  return at::log_softmax(logits, 2).clamp_min(lowest).masked_fill(counted.logical_not(), -infinity);
}

}  // namespace

Partition partition(const Tensor& logits, const Tensor& valid, const Tensor& radiance,
                    const Tensor& embedding) {
  const auto type = floating_type("partition: logits", logits);
  expect_tensor("partition: logits", "[B, S, N, H, W]", logits,
                {kAnySize, kAnySize, kAnySize, kAnySize, kAnySize}, type);
  const int64_t batch = logits.size(0), samples = logits.size(1), layers = logits.size(2),
                height = logits.size(3), width = logits.size(4);
  expect_tensor("partition: valid", "[B, S, 1, H, W]", valid, {batch, samples, 1, height, width}, type);
  expect_tensor("partition: radiance", "[B, S, 3, H, W]", radiance, {batch, samples, 3, height, width}, type);
  expect_tensor("partition: embedding", "[B, S, E, H, W]", embedding,
                {batch, samples, kAnySize, height, width}, type);

  const Tensor mask = valid.detach().ne(0);
  const Tensor any = mask.any(1, /*keepdim=*/true);  // [B, 1, 1, H, W]
  // Where no sample is valid all are counted, so that nothing divides 0 by 0, and the results are masked at
  // the end.
  const Tensor counted = mask.logical_or(any.logical_not());
  const Tensor count = counted.sum(1).to(type);  // [B, 1, H, W]
  const Tensor log_w = log_weights(logits, counted);

  std::vector<Tensor> log_n, share, transmittance;
  for (int64_t l = 0; l < layers; ++l) {
    // What each sample puts into layer l and those behind it, relative to n_l: opacity and transmittance come
    // from one softmax, so they add up to 1 however large the logits (a difference of log n would not).
    const Tensor behind = log_w.narrow(2, l, layers - l).flatten(1, 2);  // [B, S * (N-l), H, W]
    const Tensor q = at::softmax(behind, 1).unflatten(1, {samples, layers - l});
    share.push_back(q.narrow(2, 0, 1));  // w_s^l / (S n_l)
    transmittance.push_back(q.narrow(2, 1, layers - l - 1).sum({1, 2}));
    // log n_l is the log-sum-exp of `behind`: x_i - log q_i for any i. Taken at the largest, from sums that
    // the softmax did in the order of the samples, so that a masked sample changes no bit.
    log_n.push_back(l == 0 ? at::zeros({batch, 1, height, width}, logits.options())
                           : behind.amax(1, /*keepdim=*/true) -
                                 q.flatten(1, 2).amax(1, /*keepdim=*/true).log() - count.log());
  }

  const Tensor none = any.logical_not();
  const Tensor shares = at::cat(share, 2).masked_fill(none, 0);
  Partition result;
  result.log_n = at::cat(log_n, 1).masked_fill(none.squeeze(1), -std::numeric_limits<double>::infinity());
  result.radiance = weighted_sum(shares, radiance);
  result.opacity = shares.sum(1).unsqueeze(2);
  result.transmittance = at::stack(transmittance, 1).unsqueeze(2).masked_fill(none, 0);
  const Tensor weights = log_w.exp().masked_fill(none, 0) / count.unsqueeze(1);
  result.embedding = weighted_sum(weights, embedding);
  return result;
}

}  // namespace ld
