#include "ops/partition.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "ops/weighted_sum.h"
#include "tests/support/gradient_check.h"
#include "tests/support/scalar_reference.h"

namespace ld {
namespace {

using torch::Tensor;

struct Samples {
  Tensor logits, valid, radiance, embedding;
  Samples(int64_t b, int64_t s, int64_t n, int64_t h, int64_t w, double deviation = 1)
      : logits(random_normal({b, s, n, h, w}, 1, deviation)),
        valid(random_valid(b, s, h, w, 2)),
        radiance(random_uniform({b, s, 3, h, w}, 3, 0, 5) * valid),
        embedding(random_normal({b, s, 4, h, w}, 4)) {}
  Partition run(torch::ScalarType type = torch::kFloat64) const {
    return partition(logits.to(type), valid.to(type), radiance.to(type), embedding.to(type));
  }
};

/// The result in the absolute sums of eq. 2.
void expect_sums(const Partition& result, const reference::Layers& expected, const Tensor& valid,
                 double tolerance) {
  const Tensor w = to_tensor(expected.weight), n = to_tensor(expected.occupancy);
  const Tensor n_result =
      result.log_n.to(torch::kFloat64).exp().unsqueeze(2);  // exp(-inf) = 0: no valid sample
  expect_near(n_result, n, tolerance);
  expect_near(result.opacity * n_result, w, tolerance);
  expect_near(result.radiance * n_result, to_tensor(expected.radiance), tolerance);
  expect_near(result.embedding, to_tensor(expected.embedding), tolerance);
  const Tensor any = valid.ne(0).any(1, true);
  expect_near(result.transmittance, (1 - w / n).masked_fill(any.logical_not(), 0), tolerance);
}

TEST(Partition, AgreesWithTheScalarReference) {
  for (const int64_t samples : {1, 3, 8})
    for (const int64_t layers : {1, 2, 4})
      for (const auto& [h, w] : std::vector<std::pair<int64_t, int64_t>>{{1, 1}, {1, 2}, {5, 7}}) {
        const Samples in(2, samples, layers, h, w, 2);
        const auto expected = reference::partition(to_grid(in.logits), to_grid(in.valid),
                                                   to_grid(in.radiance), to_grid(in.embedding));
        expect_sums(in.run(), expected, in.valid, 1e-12);
        expect_sums(in.run(torch::kFloat32), expected, in.valid, 3e-6);
      }
}

// Each pixel's mean radiance is what its layers make together.
TEST(Partition, TheLayersMakeTheNoisyPicture) {
  const Samples in(1, 4, 3, 6, 5);
  const Tensor mean = masked_mean(in.radiance, in.valid);
  const Partition alpha = in.run();
  Tensor visible = torch::ones({1, 1, 6, 5}, torch::kFloat64), picture = torch::zeros_like(mean);
  for (int64_t l = 0; l < 3; ++l) {
    picture = picture + visible * alpha.radiance.select(1, l);
    visible = visible * alpha.transmittance.select(1, l);
  }
  expect_near(picture, mean, 1e-12);
  const Partition weighted = partition(in.logits, in.valid, in.radiance, in.embedding, Compositing::weighted);
  expect_near((weighted.log_n.exp().unsqueeze(2) * weighted.radiance).sum(1), mean, 1e-12);
}

TEST(Partition, GradientsAgreeWithFiniteDifferences) {
  const Samples in(1, 3, 3, 2, 3);
  expect_gradients(
      [&](const std::vector<Tensor>& v) {
        const Partition p = partition(v[0], in.valid, v[1], v[2]);
        // log_n is -inf at the pixel without samples: leave it out.
        return at::cat(
            {p.log_n.flatten(1).narrow(1, 0, 5), p.log_n.narrow(1, 1, 1).flatten(1).narrow(1, 0, 5),
             p.log_n.narrow(1, 2, 1).flatten(1).narrow(1, 0, 5), p.radiance.flatten(1), p.opacity.flatten(1),
             p.transmittance.flatten(1), p.embedding.flatten(1)},
            1);
      },
      {variable(in.logits), variable(in.radiance), variable(in.embedding)}, 100);
}

TEST(Partition, APixelWithoutSamplesSendsNothingAndPassesNoGradient) {
  const Samples in(1, 2, 2, 2, 2);
  const Tensor logits = variable(in.logits), radiance = variable(in.radiance),
               embedding = variable(in.embedding);
  const Partition p = partition(logits, in.valid, radiance, embedding);
  const auto last = [](const Tensor& t) { return t.select(t.dim() - 1, 1).select(t.dim() - 2, 1); };
  EXPECT_TRUE(last(p.log_n).isneginf().all().item<bool>());
  for (const Tensor& t : {p.radiance, p.opacity, p.transmittance, p.embedding})
    EXPECT_TRUE(last(t).eq(0).all().item<bool>());
  (p.log_n.exp().sum() + p.radiance.sum() + p.opacity.sum() + p.transmittance.sum() + p.embedding.sum())
      .backward();
  for (const Tensor& t : {logits, radiance, embedding}) {
    EXPECT_TRUE(all_finite(t.grad()));
    EXPECT_TRUE(last(t.grad()).eq(0).all().item<bool>());
  }
}

TEST(Partition, AnUnderflowingLayerKeepsItsRatios) {
  // Two samples far from layer 1: n_1 = exp(-500) underflows in float32, its ratios do not.
  Tensor logits = torch::zeros({1, 2, 2, 1, 1});
  logits[0][0][0][0][0] = 500;
  logits[0][1][0][0][0] = 500 + std::log(3.0F);
  Tensor radiance = torch::zeros({1, 2, 3, 1, 1});
  radiance[0][0] = 4;
  const Partition p = partition(logits, torch::ones({1, 2, 1, 1, 1}), radiance, torch::ones({1, 2, 1, 1, 1}));
  EXPECT_NEAR(p.log_n[0][1].item<double>(), -500 + std::log((1 + 1.0 / 3) / 2), 1e-4);
  EXPECT_NEAR(p.radiance[0][1][0].item<double>(), 3, 1e-4);  // weights 1 and 1/3: 4 * 1 / (4/3)
  EXPECT_EQ(p.transmittance[0][0].item<double>(), 0);
  EXPECT_NEAR(p.opacity[0][1].item<double>(), 1, 1e-6);
}

TEST(Partition, AMaskedSampleIsLikeOneThatWasRemoved) {
  Samples in(1, 4, 3, 3, 5);
  in.valid.fill_(1);
  in.valid.select(1, 2).zero_();
  Samples removed = in;
  const Tensor kept = torch::tensor({0, 1, 3});
  for (Tensor* t : {&removed.logits, &removed.valid, &removed.radiance, &removed.embedding})
    *t = t->index_select(1, kept);
  const Partition a = in.run(torch::kFloat32), b = removed.run(torch::kFloat32);
  EXPECT_TRUE(a.log_n.equal(b.log_n));
  EXPECT_TRUE(a.radiance.equal(b.radiance));
  EXPECT_TRUE(a.opacity.equal(b.opacity));
  EXPECT_TRUE(a.transmittance.equal(b.transmittance));
  EXPECT_TRUE(a.embedding.equal(b.embedding));
  // The composition's sums are LibTorch's, in an order that depends on how many there are.
  const Partition c = in.run(torch::kFloat64), e = removed.run(torch::kFloat64);
  expect_near(c.log_n, e.log_n, 1e-14);
  expect_near(c.radiance, e.radiance, 1e-14);
  expect_near(c.transmittance, e.transmittance, 1e-14);
  expect_near(c.embedding, e.embedding, 1e-14);
}

TEST(MaskedMean, AgreesWithTheScalarReference) {
  for (const auto& [h, w] : std::vector<std::pair<int64_t, int64_t>>{{1, 1}, {1, 2}, {5, 7}, {3, 700}}) {
    const Tensor values = random_normal({2, 3, 4, h, w}, 5), valid = random_valid(2, 3, h, w, 6);
    const Tensor expected = to_tensor(reference::masked_mean(to_grid(values), to_grid(valid))).squeeze(1);
    expect_near(masked_mean(values, valid), expected, 1e-14);
    expect_near(masked_mean(values.to(torch::kFloat32), valid.to(torch::kFloat32)), expected, 1e-6);
  }
}

TEST(WeightedSum, GradientsAgreeWithFiniteDifferences) {
  expect_gradients([](const auto& v) { return weighted_sum(v[0], v[1]); },
                   {variable(random_normal({2, 3, 2, 2, 5}, 7)), variable(random_normal({2, 3, 4, 2, 5}, 8))},
                   120);
}

// Light in two forms side by side is what each of them is alone.
TEST(Partition, TakesAnyNumberOfRadianceChannels) {
  for (const Compositing compositing : {Compositing::alpha, Compositing::weighted}) {
    const Samples in(2, 3, 2, 5, 7);
    const auto single = [](const Tensor& t) { return t.to(torch::kFloat32); };
    const auto run = [&](const Tensor& radiance) {
      return partition(single(in.logits), single(in.valid), single(radiance), single(in.embedding),
                       compositing);
    };
    const Tensor other = in.radiance * 3 + 1;
    const Partition both = run(at::cat({other, in.radiance}, 2)), first = run(other),
                    second = run(in.radiance);
    EXPECT_TRUE(both.radiance.equal(at::cat({first.radiance, second.radiance}, 2)));
    EXPECT_TRUE(both.log_n.equal(second.log_n));
  }
}

TEST(Partition, BadShapesAreErrors) {
  const Samples in(1, 2, 2, 3, 4);
  EXPECT_THROW(partition(in.logits[0], in.valid, in.radiance, in.embedding), Error);
  EXPECT_THROW(partition(in.logits, in.valid.narrow(1, 0, 1), in.radiance, in.embedding), Error);
  EXPECT_THROW(partition(in.logits, in.valid, in.radiance.narrow(3, 0, 1), in.embedding), Error);
  EXPECT_THROW(partition(in.logits, in.valid, in.radiance, in.embedding.narrow(4, 0, 3)), Error);
  EXPECT_THROW(partition(in.logits, in.valid.to(torch::kFloat32), in.radiance, in.embedding), Error);
  EXPECT_THROW(masked_mean(in.embedding, in.valid.narrow(3, 0, 1)), Error);
  EXPECT_THROW(weighted_sum(in.logits.narrow(1, 0, 1), in.embedding), Error);
}

}  // namespace
}  // namespace ld
