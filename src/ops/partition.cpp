#include "ops/partition.h"

#include <ATen/Parallel.h>

#include "ops/composition.h"
#include "ops/expect_tensor.h"
#include "ops/kernels/partition_tile.h"
#include "ops/pictures.h"

namespace ld {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

/// The arguments, contiguous.
struct PartitionArguments {
  Tensor logits, valid, radiance, embedding;
  PartitionShape shape;
  int64_t pixels;  // of a picture

  PartitionArguments(const Tensor& z, const Tensor& v, const Tensor& r, const Tensor& e, bool alpha)
      : logits(z.contiguous()),
        valid(v.contiguous()),
        radiance(r.contiguous()),
        embedding(e.contiguous()),
        shape{z.size(1), z.size(2), r.size(2), e.size(2), alpha},
        pixels(z.size(3) * z.size(4)) {}

  Tensor like(int64_t planes) const {
    return at::empty({logits.size(0), shape.layers, planes, logits.size(3), logits.size(4)},
                     logits.options());
  }

  /// Pixels from `begin` on of a picture, which may be null.
  PlanarRow from(const float* picture, int64_t begin) const {
    return {picture == nullptr ? nullptr : picture + begin, pixels};
  }
  PlanarTarget from(float* picture, int64_t begin) const {
    return {picture == nullptr ? nullptr : picture + begin, pixels};
  }

  /// Calls body(picture, input, first pixel, count, scratch) for every tile, on all threads.
  template <class Body>
  void for_each_tile(const Body& body) const {
    const Pictures<float> z(logits), v(valid), r(radiance), e(embedding);
    const int64_t tiles = (pixels + kPartitionPixels - 1) / kPartitionPixels;
    at::parallel_for(0, logits.size(0) * tiles, 1, [&](int64_t first, int64_t last) {
      PartitionScratch scratch(shape);
      for (int64_t i = first; i < last; ++i) {
        const int64_t b = i / tiles, begin = i % tiles * kPartitionPixels;
        const auto tile = [&](auto* picture) { return from(picture, begin); };
        body(b, PartitionInput{tile(z[b]), tile(v[b]), tile(r[b]), tile(e[b])}, begin,
             std::min(kPartitionPixels, pixels - begin), scratch);
      }
    });
  }
};

class SamplePartition : public torch::autograd::Function<SamplePartition> {
 public:
  /// {log_n, radiance, opacity, embedding} and, for alpha, transmittance.
  static variable_list forward(AutogradContext* context, const Tensor& logits, const Tensor& valid,
                               const Tensor& radiance, const Tensor& embedding, bool alpha) {
    const PartitionArguments problem(logits, valid, radiance, embedding, alpha);
    context->save_for_backward({problem.logits, problem.valid, problem.radiance, problem.embedding});
    context->saved_data["alpha"] = alpha;
    context->set_materialize_grads(false);
    const Tensor log_n = problem.like(1).squeeze(2), shares = problem.like(problem.shape.channels),
                 opacity = problem.like(1), transmittance = alpha ? problem.like(1) : Tensor(),
                 features = problem.like(problem.shape.embedding);
    const Pictures<float> n(log_n), r(shares), o(opacity), t(transmittance), e(features);
    problem.for_each_tile(
        [&](int64_t b, const PartitionInput& in, int64_t begin, int64_t count, PartitionScratch& scratch) {
          const auto tile = [&](float* picture) { return problem.from(picture, begin); };
          partition_tile(problem.shape, in, {tile(n[b]), tile(r[b]), tile(o[b]), tile(t[b]), tile(e[b])},
                         count, scratch);
        });
    variable_list results = {log_n, shares, opacity, features};
    if (alpha) results.push_back(transmittance);
    return results;
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const variable_list saved = context->get_saved_variables();
    const bool alpha = context->saved_data["alpha"].toBool();
    const PartitionArguments problem(saved[0], saved[1], saved[2], saved[3], alpha);
    for (Tensor& gradient : gradients)
      if (gradient.defined()) gradient = gradient.contiguous();
    Tensor radiance_gradient, embedding_gradient;
    const Tensor logits_gradient = at::empty_like(problem.logits);
    if (problem.radiance.requires_grad()) radiance_gradient = at::empty_like(problem.radiance);
    if (problem.embedding.requires_grad()) embedding_gradient = at::empty_like(problem.embedding);
    const Pictures<float> n(gradients[0]), r(gradients[1]), o(gradients[2]), e(gradients[3]),
        t(alpha ? gradients[4] : Tensor());
    const Pictures<float> gz(logits_gradient), gr(radiance_gradient), ge(embedding_gradient);
    problem.for_each_tile([&](int64_t b, const PartitionInput& in, int64_t begin, int64_t count,
                              PartitionScratch& scratch) {
      const auto tile = [&](float* picture) { return problem.from(picture, begin); };
      partition_tile_backward(problem.shape, in, {tile(n[b]), tile(r[b]), tile(o[b]), tile(t[b]), tile(e[b])},
                              {tile(gz[b]), tile(gr[b]), tile(ge[b])}, count, scratch);
    });
    return {logits_gradient, Tensor(), radiance_gradient, embedding_gradient, Tensor()};
  }
};

}  // namespace

Partition partition(const Tensor& logits, const Tensor& valid, const Tensor& radiance,
                    const Tensor& embedding, Compositing compositing) {
  const auto type = floating_type("partition: logits", logits);
  expect_tensor("partition: logits", "[B, S, N, H, W]", logits,
                {kAnySize, kAnySize, kAnySize, kAnySize, kAnySize}, type);
  const int64_t batch = logits.size(0), samples = logits.size(1), height = logits.size(3),
                width = logits.size(4);
  expect_tensor("partition: valid", "[B, S, 1, H, W]", valid, {batch, samples, 1, height, width}, type);
  expect_tensor("partition: radiance", "[B, S, C, H, W]", radiance, {batch, samples, kAnySize, height, width},
                type);
  expect_tensor("partition: embedding", "[B, S, E, H, W]", embedding,
                {batch, samples, kAnySize, height, width}, type);
  if (runs_composed(logits))
    return composed::partition(logits, valid.detach(), radiance, embedding, compositing);
  const bool alpha = compositing == Compositing::alpha;
  const variable_list results = SamplePartition::apply(logits, valid.detach(), radiance, embedding, alpha);
  return {results[0], results[1], results[2], alpha ? results[4] : Tensor(), results[3]};
}

}  // namespace ld
