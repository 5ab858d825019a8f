// The warp against closed forms, against plain loops, at the extremes, and its gradient.
#include "ops/warp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ops/kernels/warp_taps.h"
#include "tests/support/expect_error.h"
#include "tests/support/gradient_check.h"

namespace ld {
namespace {

using torch::Tensor;

constexpr double kNever = std::numeric_limits<double>::quiet_NaN();

Tensor constant_flow(int64_t h, int64_t w, double x, double y) {
  Tensor flow = torch::empty({1, 2, h, w}, torch::kFloat64);
  flow.select(1, 0).fill_(x);
  flow.select(1, 1).fill_(y);
  return flow;
}

Tensor everywhere_valid(int64_t h, int64_t w) {
  return torch::ones({1, 1, h, w}, torch::kFloat64);
}

/// The contract, a pixel at a time; NaN where the result is invalid.
double looked_up(const Tensor& values, const Tensor& flow, const Tensor& valid, int64_t c, int64_t y,
                 int64_t x) {
  const double px = double(x) + flow[0][0][y][x].item<double>(),
               py = double(y) + flow[0][1][y][x].item<double>();
  if (!std::isfinite(px) || !std::isfinite(py)) return kNever;
  double sum = 0, weights = 0;
  for (int64_t v = 0; v < values.size(2); ++v)
    for (int64_t u = 0; u < values.size(3); ++u) {
      const double weight =
          std::max(0.0, 1 - std::abs(px - double(u))) * std::max(0.0, 1 - std::abs(py - double(v)));
      if (weight == 0 || valid[0][0][v][u].item<double>() == 0) continue;
      weights += weight;
      sum += weight * values[0][c][v][u].item<double>();
    }
  return weights < 0.01 ? kNever : sum / weights;
}

void expect_contract(const Tensor& values, const Tensor& flow, const Tensor& valid) {
  const Warped warped = warp(values, flow, valid);
  for (int64_t y = 0; y < values.size(2); ++y)
    for (int64_t x = 0; x < values.size(3); ++x)
      for (int64_t c = 0; c < values.size(1); ++c) {
        const double expected = looked_up(values, flow, valid, c, y, x);
        EXPECT_EQ(warped.valid[0][0][y][x].item<double>(), std::isnan(expected) ? 0 : 1) << x << ", " << y;
        EXPECT_NEAR(warped.values[0][c][y][x].item<double>(), std::isnan(expected) ? 0 : expected, 1e-12)
            << x << ", " << y;
      }
}

TEST(Warp, AgreesWithPlainLoops) {
  for (const auto& [h, w] : std::vector<std::pair<int64_t, int64_t>>{{1, 1}, {1, 7}, {5, 1}, {6, 9}}) {
    const Tensor valid = random_uniform({1, 1, h, w}, 3).gt(0.2).to(torch::kFloat64);
    expect_contract(random_normal({1, 3, h, w}, 1), random_normal({1, 2, h, w}, 2, 2), valid);
    expect_contract(random_normal({1, 3, h, w}, 1), random_normal({1, 2, h, w}, 2, 0.3),
                    everywhere_valid(h, w));
  }
}

TEST(Warp, WholePixelsAreAShiftBitForBit) {
  const Tensor values = random_normal({1, 2, 4, 6}, 1);
  const Warped warped = warp(values, constant_flow(4, 6, 2, -1), everywhere_valid(4, 6));
  EXPECT_TRUE(warped.values.slice(2, 1).slice(3, 0, 4).equal(values.slice(2, 0, 3).slice(3, 2)));
  EXPECT_EQ(warped.values.slice(2, 0, 1).abs().sum().item<double>(), 0);
  EXPECT_EQ(warped.values.slice(3, 4).abs().sum().item<double>(), 0);
  EXPECT_EQ(warped.valid.sum().item<double>(), 3 * 4);
}

TEST(Warp, HalfPixelsAreMeansAndBordersCountWhatIsThere) {
  const Tensor values = random_normal({1, 1, 3, 5}, 1);
  const Warped warped = warp(values, constant_flow(3, 5, 0.5, 0), everywhere_valid(3, 5));
  const Tensor means = 0.5 * (values.slice(3, 0, 4) + values.slice(3, 1));
  EXPECT_LE((warped.values.slice(3, 0, 4) - means).abs().max().item<double>(), 1e-15);
  EXPECT_TRUE(warped.values.slice(3, 4).equal(values.slice(3, 4)));  // half of its place is outside
  EXPECT_EQ(warped.valid.sum().item<double>(), 15);
}

TEST(Warp, AnInvalidPixelIsLeftOutOfTheMeanAndAWholeFootprintIsInvalid) {
  const Tensor values = random_normal({1, 1, 1, 4}, 1);
  Tensor valid = everywhere_valid(1, 4);
  valid[0][0][0][1] = 0;
  const Warped between = warp(values, constant_flow(1, 4, 0.25, 0), valid);
  EXPECT_DOUBLE_EQ(between.values[0][0][0][0].item<double>(), values[0][0][0][0].item<double>());
  EXPECT_DOUBLE_EQ(between.values[0][0][0][1].item<double>(), values[0][0][0][2].item<double>());
  const Warped exactly = warp(values, constant_flow(1, 4, 0, 0), valid);
  EXPECT_EQ(exactly.valid[0][0][0][1].item<double>(), 0);
  EXPECT_EQ(exactly.values[0][0][0][1].item<double>(), 0);
}

TEST(Warp, NothingThatIsNotFiniteSpreads) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const torch::ScalarType type : {torch::kFloat32, torch::kFloat64}) {
    Tensor values = torch::full({1, 2, 3, 4}, 3e38, type);
    values[0][0][1][1] = infinity;
    values[0][1][1][2] = kNever;
    Tensor flow = constant_flow(3, 4, 0.5, 0.5).to(type);
    flow[0][0][0][3] = kNever;
    flow[0][0][1][3] = infinity;
    flow[0][1][2][3] = 3e38;
    flow[0][1][2][2] = -3e38;
    flow[0][0][2][1] = 1e-38;
    const Warped warped = warp(values, flow, everywhere_valid(3, 4).to(type));
    EXPECT_TRUE(warped.values.isfinite().all().item<bool>());
    EXPECT_NEAR(warped.values.max().item<double>(), 3e38, 1e32);
    for (const auto& [y, x] : std::vector<std::pair<int, int>>{{0, 3}, {1, 3}, {2, 3}, {2, 2}})
      EXPECT_EQ(warped.valid[0][0][y][x].item<double>(), 0) << x << ", " << y;
    EXPECT_EQ(warped.valid[0][0][0][1].item<double>(), 1);  // above the two that do not count
  }
}

TEST(Warp, GradientsAgreeWithFiniteDifferences) {
  const Tensor flow = random_normal({2, 2, 5, 6}, 2),
               valid = random_uniform({2, 1, 5, 6}, 3).gt(0.2).to(torch::kFloat64);
  const Tensor values = random_normal({2, 3, 5, 6}, 1).requires_grad_(true);
  expect_gradients([&](const std::vector<Tensor>& in) { return warp(in[0], flow, valid).values; }, {values});
}

/// Surfaces of two depths and two normals, in stripes and as noise.
WarpGuides striped_guides(int64_t h, int64_t w) {
  const auto surfaces = [&](uint32_t seed) {
    Tensor planes = torch::zeros({1, 4, h, w}, torch::kFloat64);
    planes.select(1, 0) = 0.5 + 0.2 * random_uniform({1, h, w}, seed).gt(0.5).to(torch::kFloat64);
    planes.select(1, 3) = 1 - 2 * random_uniform({1, h, w}, seed + 1).gt(0.7).to(torch::kFloat64);
    return planes;
  };
  return {surfaces(11), surfaces(21)};
}

// A tap that shows another surface is as one that is not valid.
TEST(Warp, GuidesLeaveOtherSurfacesOut) {
  const int64_t h = 6, w = 9;
  const WarpGuides guides = striped_guides(h, w);
  const Tensor values = random_normal({1, 3, h, w}, 1), flow = random_normal({1, 2, h, w}, 2, 0.7);
  const Warped warped = warp(values, flow, everywhere_valid(h, w), guides);
  int64_t differ = 0;
  for (int64_t y = 0; y < h; ++y)
    for (int64_t x = 0; x < w; ++x) {
      const Tensor here = guides.now.select(3, x).select(2, y).view({1, 4, 1, 1});
      const Tensor same = guides.before.eq(here).all(1, true).to(torch::kFloat64);
      const double expected = looked_up(values, flow, same, 0, y, x);
      differ += std::isnan(expected) ? 1 : 0;
      EXPECT_EQ(warped.valid[0][0][y][x].item<double>(), std::isnan(expected) ? 0 : 1) << x << ", " << y;
      EXPECT_NEAR(warped.values[0][0][y][x].item<double>(), std::isnan(expected) ? 0 : expected, 1e-12);
    }
  EXPECT_GT(differ, 0);
  const Tensor zeros = torch::zeros({1, 4, h, w}, torch::kFloat64);
  EXPECT_TRUE(warp(values, flow, everywhere_valid(h, w), {zeros, zeros})
                  .values.equal(warp(values, flow, everywhere_valid(h, w)).values));
  const Tensor nothing = torch::full({1, 4, h, w}, kNever);
  EXPECT_EQ(warp(values, flow, everywhere_valid(h, w), {nothing.to(torch::kFloat64), guides.before})
                .valid.sum()
                .item<double>(),
            0);
  expect_gradients(
      [&](const std::vector<Tensor>& in) { return warp(in[0], flow, everywhere_valid(h, w), guides).values; },
      {values.clone().requires_grad_(true)});
}

TEST(Warp, EscapedRaysAreOneSurfaceAndDepthsMayDifferByAQuarter) {
  const auto same = [](double a, double b) {
    return may_be_same_surface(GuideSurface<float>{float(a), 0, 0, 1},
                               GuideSurface<float>{float(b), 0, 0, 1});
  };
  EXPECT_TRUE(same(1, 1));
  EXPECT_TRUE(same(0, 0));
  EXPECT_FALSE(same(1, 0.99));
  EXPECT_FALSE(same(0, 0.01));
  EXPECT_TRUE(same(0.5, 1.24 / 2.24));
  EXPECT_FALSE(same(0.5, 1.26 / 2.26));
  EXPECT_FALSE(same(0.5, kNever));
}

TEST(Warp, ThreadsChangeNoBit) {
  const Tensor flow = random_normal({2, 2, 40, 50}, 2, 3).to(torch::kFloat32);
  const Tensor valid = torch::ones({2, 1, 40, 50});
  std::vector<Tensor> results;
  const int before = torch::get_num_threads();
  for (const int threads : {1, 2, 3}) {
    torch::set_num_threads(threads);
    const Tensor values = random_normal({2, 3, 40, 50}, 1).to(torch::kFloat32).requires_grad_(true);
    const Tensor out = warp(values, flow, valid).values;
    out.square().sum().backward();
    results.push_back(torch::cat({out.detach(), values.grad()}));
  }
  torch::set_num_threads(before);
  EXPECT_TRUE(results[0].equal(results[1]));
  EXPECT_TRUE(results[0].equal(results[2]));
}

TEST(Warp, BadShapesAreErrors) {
  const Tensor values = torch::ones({1, 3, 4, 5});
  EXPECT_ERROR(warp(values, torch::ones({1, 2, 4, 4}), torch::ones({1, 1, 4, 5})), "warp: flow");
  EXPECT_ERROR(warp(values, torch::ones({1, 2, 4, 5}), torch::ones({1, 3, 4, 5})), "warp: valid");
  EXPECT_ERROR(
      warp(values, torch::ones({1, 2, 4, 5}), torch::ones({1, 1, 4, 5}), {torch::ones({1, 4, 4, 5}), {}}),
      "warp: guides");
  EXPECT_ERROR(warp(values.to(torch::kInt), torch::ones({1, 2, 4, 5}), torch::ones({1, 1, 4, 5})),
               "warp: values");
}

}  // namespace
}  // namespace ld
