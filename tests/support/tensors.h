// Random tensors that depend on their seed alone, and the way between tensors and the references' grids.
#pragma once

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <cstring>

#include "core/random.h"
#include "tests/support/grid.h"

namespace ld {

/// Standard normal numbers times `deviation`, float64.
inline torch::Tensor random_normal(torch::IntArrayRef sizes, uint32_t seed, double deviation = 1) {
  RandomStream stream(seed, RandomPurpose::test);
  torch::Tensor t = torch::empty(sizes, torch::kFloat64);
  for (int64_t i = 0; i < t.numel(); ++i) t.data_ptr<double>()[i] = deviation * stream.normal();
  return t;
}

/// Uniform in [low, high), float64.
inline torch::Tensor random_uniform(torch::IntArrayRef sizes, uint32_t seed, double low = 0,
                                    double high = 1) {
  RandomStream stream(seed, RandomPurpose::test);
  torch::Tensor t = torch::empty(sizes, torch::kFloat64);
  for (int64_t i = 0; i < t.numel(); ++i) t.data_ptr<double>()[i] = low + (high - low) * stream.uniform();
  return t;
}

/// [B, S, 1, H, W] of 0 and 1: about a quarter of the samples missing, and one pixel (the last) without any.
inline torch::Tensor random_valid(int64_t b, int64_t s, int64_t h, int64_t w, uint32_t seed) {
  torch::Tensor valid = random_uniform({b, s, 1, h, w}, seed).gt(0.25).to(torch::kFloat64);
  if (h * w > 1) valid.select(3, h - 1).select(3, w - 1).zero_();
  return valid;
}

/// A tensor of 5 axes, or of 4 (S = 1 put in as the second).
inline reference::Grid to_grid(const torch::Tensor& tensor) {
  const torch::Tensor t =
      (tensor.dim() == 4 ? tensor.unsqueeze(1) : tensor).detach().to(torch::kFloat64).contiguous();
  reference::Grid grid(t.size(0), t.size(1), t.size(2), t.size(3), t.size(4));
  std::memcpy(grid.values.data(), t.data_ptr<double>(), grid.values.size() * sizeof(double));
  return grid;
}

inline torch::Tensor to_tensor(const reference::Grid& g) {
  return torch::tensor(g.values, torch::kFloat64).view({g.b, g.s, g.c, g.h, g.w});
}

inline double largest_difference(const torch::Tensor& a, const torch::Tensor& b) {
  return (a.detach().to(torch::kFloat64) - b.detach().to(torch::kFloat64)).abs().max().item<double>();
}

/// |actual - expected| <= tolerance * (1 + |expected|) everywhere; NaN fails.
inline void expect_near(const torch::Tensor& actual, const torch::Tensor& expected, double tolerance) {
  ASSERT_EQ(actual.numel(), expected.numel());
  const torch::Tensor a = actual.detach().to(torch::kFloat64).flatten(),
                      e = expected.detach().to(torch::kFloat64).flatten();
  const torch::Tensor error = (a - e).abs() / (1 + e.abs());
  EXPECT_TRUE(error.le(tolerance).all().item<bool>())
      << "largest error " << error.max().item<double>() << ", allowed " << tolerance;
}

inline bool all_finite(const torch::Tensor& t) {
  return t.isfinite().all().item<bool>();
}

}  // namespace ld
