#include "ops/kernel_splat.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "tests/support/gradient_check.h"
#include "tests/support/scalar_reference.h"

namespace ld {
namespace {

using torch::Tensor;

struct SplatProblem {
  Tensor logits, log_n, values;
  SplatProblem(int64_t b, int64_t layers, int64_t kernel, int64_t channels, int64_t h, int64_t w,
               double deviation)
      : logits(random_normal({b, layers, kernel * kernel, h, w}, 1, deviation)),
        log_n(random_normal({b, layers, h, w}, 2).sub(1)),
        values(random_uniform({b, layers, channels, h, w}, 3, 0, 4)) {}
  Tensor run(torch::ScalarType type = torch::kFloat64) const {
    return kernel_splat(logits.to(type), log_n.to(type), values.to(type));
  }
  /// Scattered n * v over scattered n; 0 where no n arrives.
  Tensor expected() const {
    const Tensor n = log_n.exp().unsqueeze(2);
    const Tensor above = to_tensor(reference::splat(to_grid(logits), to_grid(values * n)));
    const Tensor below = to_tensor(reference::splat(to_grid(logits), to_grid(n)));
    return at::where(below.gt(0), above / below, at::zeros_like(above));
  }
};

TEST(KernelSplat, AgreesWithTheScalarReference) {
  for (const auto& [h, w] : std::vector<std::pair<int64_t, int64_t>>{{1, 1}, {1, 2}, {5, 7}, {2, 300}})
    for (const int64_t kernel : {1, 3, 5, 9})
      for (const int64_t layers : {1, 2, 3}) {
        const SplatProblem p(2, layers, kernel, 4, h, w, 2);
        const Tensor expected = p.expected();
        expect_near(p.run(), expected, 1e-12);
        expect_near(p.run(torch::kFloat32), expected, 1e-5);
      }
}

TEST(KernelSplat, SinglePrecisionErrsAsTheExponentsDo) {
  for (const double deviation : {10.0, 30.0, 60.0}) {  // beyond, the reference's own exp() underflows
    const SplatProblem p(1, 2, 5, 3, 6, 5, deviation);
    const Tensor expected = p.expected();
    const double largest_exponent = (p.logits.max() - p.logits.min()).item<double>();
    EXPECT_LE(largest_difference(p.run(torch::kFloat32), expected),
              4 * std::ldexp(1.0, -23) * (1 + largest_exponent) * 4);
    expect_near(p.run(), expected, 1e-11);
  }
}

TEST(KernelSplat, PixelsThatSendNothing) {
  SplatProblem p(1, 2, 3, 2, 3, 4, 1);
  const double infinity = std::numeric_limits<double>::infinity();
  p.log_n.select(3, 1).fill_(-infinity);
  expect_near(p.run(), p.expected(), 1e-12);
  p.log_n.fill_(-infinity);
  p.log_n.select(3, 0).select(2, 0).fill_(0);  // only the corner sends: it reaches 2 x 2 pixels
  const Tensor out = p.run();
  EXPECT_TRUE(out.narrow(3, 0, 2).narrow(4, 0, 2).gt(0).all().item<bool>());
  EXPECT_TRUE(out.narrow(4, 2, 2).eq(0).all().item<bool>());
  EXPECT_TRUE(out.narrow(3, 2, 1).eq(0).all().item<bool>());
  const Tensor logits = variable(p.logits.to(torch::kFloat32)),
               values = variable(p.values.to(torch::kFloat32));
  kernel_splat(logits, p.log_n.to(torch::kFloat32), values).sum().backward();
  EXPECT_TRUE(all_finite(logits.grad()));
  EXPECT_TRUE(all_finite(values.grad()));
}

TEST(KernelSplat, TapsReachTheDocumentedPixels) {
  const int64_t kernel = 3;
  for (int64_t tap = 0; tap < kernel * kernel; ++tap) {
    Tensor logits = torch::full({1, 1, 9, 5, 5}, -80.0);
    logits.select(2, tap).fill_(0);
    const Tensor values = random_uniform({1, 1, 1, 5, 5}, 4).to(torch::kFloat32);
    const Tensor out = kernel_splat(logits, torch::zeros({1, 1, 5, 5}), values);
    const int64_t dy = tap / 3 - 1, dx = tap % 3 - 1;
    for (int64_t y = 1; y < 4; ++y)
      for (int64_t x = 1; x < 4; ++x)
        EXPECT_FLOAT_EQ(out[0][0][0][y + dy][x + dx].item<float>(), values[0][0][0][y][x].item<float>())
            << tap;
  }
}

TEST(KernelSplat, GradientsAgreeWithFiniteDifferences) {
  for (const int64_t layers : {1, 2})
    for (const auto& [h, w] : std::vector<std::pair<int64_t, int64_t>>{{1, 1}, {3, 4}}) {
      const SplatProblem p(2, layers, 3, 4, h, w, 1.5);
      expect_gradients([](const auto& v) { return kernel_splat(v[0], v[1], v[2]); },
                       {variable(p.logits), variable(p.log_n), variable(p.values)}, 200);
    }
}

TEST(KernelSplat, TheGradientOfTheMaximumFlows) {
  // One source decides how much of it arrives: raising its largest logit lowers the weight of its other taps.
  Tensor logits = torch::zeros({1, 1, 9, 1, 2}, torch::kFloat64);
  logits[0][0][4][0][0] = 1;  // the centre tap of the left pixel is its largest
  logits.set_requires_grad(true);
  const Tensor values = torch::tensor({1.0, 0.0}, torch::kFloat64).view({1, 1, 1, 1, 2});
  const Tensor right = kernel_splat(logits, torch::zeros({1, 1, 1, 2}, torch::kFloat64), values).select(4, 1);
  right.sum().backward();
  // At the right pixel: a = exp(0 - 1) from the left, 1 from itself; d/dm of a/(a+1) is -a/(a+1)^2.
  const double a = std::exp(-1.0);
  EXPECT_NEAR(right.item<double>(), a / (a + 1), 1e-15);
  EXPECT_NEAR(logits.grad()[0][0][4][0][0].item<double>(), -a / ((a + 1) * (a + 1)), 1e-15);
}

TEST(KernelSplat, Adding1024ToTheLogitsOfAPixelChangesNoBit) {
  SplatProblem p(1, 2, 5, 4, 7, 6, 100);
  const Tensor logits = (p.logits * 1024).round().div(1024).clamp(-1000, 1000).to(torch::kFloat32);
  const Tensor shift = random_uniform({1, 1, 1, 7, 6}, 9).gt(0.5).to(torch::kFloat32) * 1024;
  const Tensor log_n = p.log_n.to(torch::kFloat32), values = p.values.to(torch::kFloat32);
  EXPECT_TRUE(kernel_splat(logits, log_n, values).equal(kernel_splat(logits + shift, log_n, values)));
}

TEST(KernelSplat, ThreadsChangeNoBit) {
  const SplatProblem p(2, 2, 5, 4, 33, 41, 3);
  const int threads = at::get_num_threads();
  std::vector<Tensor> results;
  for (const int count : {1, 2, 2}) {
    at::set_num_threads(count);
    const Tensor logits = variable(p.logits.to(torch::kFloat32)),
                 log_n = variable(p.log_n.to(torch::kFloat32)),
                 values = variable(p.values.to(torch::kFloat32));
    const Tensor out = kernel_splat(logits, log_n, values);
    out.square().sum().backward();
    results.insert(results.end(), {out, logits.grad(), log_n.grad(), values.grad()});
  }
  at::set_num_threads(threads);
  for (size_t i = 4; i < results.size(); ++i) EXPECT_TRUE(results[i].equal(results[i % 4])) << i;
}

TEST(KernelSplat, InferenceModeGivesTheSameBits) {
  const SplatProblem p(1, 2, 5, 4, 9, 300, 3);
  const Tensor expected = kernel_splat(variable(p.logits), p.log_n, p.values).detach();
  const c10::InferenceMode guard;
  EXPECT_TRUE(p.run().equal(expected));
}

TEST(KernelSplat, BadShapesAreErrors) {
  const SplatProblem p(1, 2, 3, 4, 5, 6, 1);
  EXPECT_THROW(kernel_splat(p.logits.narrow(2, 0, 8), p.log_n, p.values), Error);
  EXPECT_THROW(kernel_splat(p.logits.narrow(2, 0, 4), p.log_n, p.values), Error);
  EXPECT_THROW(kernel_splat(p.logits, p.log_n.narrow(1, 0, 1), p.values), Error);
  EXPECT_THROW(kernel_splat(p.logits, p.log_n, p.values.narrow(3, 0, 4)), Error);
  EXPECT_THROW(kernel_splat(p.logits, p.log_n, p.values.to(torch::kFloat32)), Error);
  EXPECT_THROW(kernel_splat(p.logits.to(torch::kInt32), p.log_n, p.values), Error);
}

}  // namespace
}  // namespace ld
