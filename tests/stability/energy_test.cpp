// Energy: a constant stays what it is, nothing leaves the range of what was sampled, nothing hidden shows.
#include <gtest/gtest.h>

#include <cmath>

#include "ops/kernel_gather.h"
#include "tests/stability/filters.h"

namespace ld {
namespace {

using torch::Tensor;

const std::vector<double> kDeviations = {1, 10, 100, 1e3, 1e4};

double worst_ratio_error(const Tensor& result, double constant) {
  return (result.to(torch::kFloat64) / constant - 1).abs().max().item<double>();
}

TEST(Energy, AConstantStaysForLogitsOfAnyDeviationAndOneToEightLayers) {
  for (const double deviation : kDeviations)
    for (int64_t layers = 1; layers <= 8; ++layers)
      for (const int64_t kernel : {1, 5, 17}) {
        FilterInput input = filter_input(layers, kernel, 3, 13, 11, deviation, uint32_t(layers));
        input.radiance.fill_(0.7F);
        for (const Compositing compositing : {Compositing::alpha, Compositing::weighted})
          EXPECT_LE(worst_ratio_error(input.run(compositing), 0.7F), 1e-5)
              << "deviation " << deviation << ", " << layers << " layers, kernel " << kernel;
      }
}

TEST(Energy, AConstantStaysWhenAGatherOrSampleSplatFiltersIt) {
  for (const double deviation : kDeviations)
    for (const int64_t kernel : {1, 5, 17}) {
      const Tensor logits = random_normal({1, 4, kernel * kernel, 13, 11}, 3, deviation).to(torch::kFloat32);
      const Tensor ones = torch::full({1, 4, 3, 13, 11}, 0.7F), log_n = torch::zeros({1, 4, 13, 11});
      EXPECT_LE(worst_ratio_error(kernel_splat_joint(logits, log_n, ones), 0.7F), 1e-5) << deviation;
      EXPECT_LE(
          worst_ratio_error(kernel_gather(logits.select(1, 0), log_n.select(1, 0), ones.select(1, 0)), 0.7F),
          1e-5)
          << deviation;
    }
}

// Kernels that all point to the upper left leave the lower right of the picture almost without light.
TEST(Energy, AConstantStaysAtBordersThatKernelsPointAwayFrom) {
  for (const double strength : {10.0, 100.0, 1e4}) {
    FilterInput input = filter_input(3, 5, 2, 12, 12, 1, 5);
    input.radiance.fill_(0.7F);
    input.kernel_logits.select(2, 0).add_(strength);
    for (const Compositing compositing : {Compositing::alpha, Compositing::weighted})
      EXPECT_LE(worst_ratio_error(input.run(compositing), 0.7F), 1e-5) << strength;
  }
}

/// Smallest and largest over the samples in the K x K neighbourhood, [1, 3, H, W] each.
std::pair<Tensor, Tensor> neighbourhood_range(const Tensor& radiance, const Tensor& valid, int64_t kernel) {
  const double infinity = std::numeric_limits<double>::infinity();
  const Tensor missing = valid.eq(0);
  const Tensor high = radiance.masked_fill(missing, -infinity).amax(1);
  const Tensor low = radiance.masked_fill(missing, infinity).amin(1);
  return {-at::max_pool2d(-low, kernel, 1, kernel / 2), at::max_pool2d(high, kernel, 1, kernel / 2)};
}

TEST(Energy, TheResultLiesWithinTheSamplesInReach) {
  for (const double deviation : kDeviations)
    for (const int64_t layers : {1, 2, 5}) {
      FilterInput input = filter_input(layers, 5, 3, 14, 12, deviation, uint32_t(20 + layers));
      input.valid = random_valid(1, 3, 14, 12, 9).to(torch::kFloat32);
      input.radiance = input.radiance.pow(8);  // 0 to 65536
      const auto [low, high] = neighbourhood_range(input.radiance, input.valid, 5);
      for (const Compositing compositing : {Compositing::alpha, Compositing::weighted}) {
        const Tensor result = input.run(compositing);
        EXPECT_TRUE(result.ge(low * (1 - 1e-5)).all().item<bool>()) << deviation << ", " << layers;
        EXPECT_TRUE(result.le(high * (1 + 1e-5)).all().item<bool>()) << deviation << ", " << layers;
      }
    }
}

/// A firefly of 1/w in the middle, in a layer of weight w behind one of weight 1 - w; its own kernel hides it
/// from the front layer at its place.
FilterInput hidden_firefly(double w) {
  FilterInput input = filter_input(2, 5, 1, 11, 11, 1, 30);
  input.radiance.fill_(1);
  input.radiance.select(3, 5).select(3, 5).fill_(1 / w);
  input.partition_logits.zero_();
  input.partition_logits.select(2, 1).fill_(std::log(w));
  const Tensor kernels = input.kernel_logits.select(3, 5).select(3, 5).squeeze(0);  // [N, K*K] of that pixel
  kernels.fill_(-200);
  kernels[0][0] = 0;   // in front: to the corner
  kernels[1][12] = 0;  // behind: to itself
  return input;
}

TEST(Energy, AHiddenFireflyKeepsItsShare) {
  for (const double w : {1e-2, 1e-4, 1e-6, 1e-10, 1e-20, 1e-30}) {
    const FilterInput input = hidden_firefly(w);
    const FilterInput twice = {input.partition_logits.to(torch::kFloat64),
                               input.kernel_logits.to(torch::kFloat64), input.valid.to(torch::kFloat64),
                               input.radiance.to(torch::kFloat64)};
    for (const Compositing compositing : {Compositing::alpha, Compositing::weighted}) {
      const Tensor exact = twice.run(compositing).select(2, 5).select(2, 5);
      const Tensor single = input.run(compositing).select(2, 5).select(2, 5).to(torch::kFloat64);
      EXPECT_LE((single / exact - 1).abs().max().item<double>(), 1e-6) << w;
    }
  }
}

}  // namespace
}  // namespace ld
