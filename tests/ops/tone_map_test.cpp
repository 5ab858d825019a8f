#include "ops/tone_map_tensor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "tests/support/gradient_check.h"

namespace ld {
namespace {

/// eq. 7 and 8 in long double, with a = 0.055.
long double tone_map_reference(long double x) {
  const long double y = std::log1p(x);
  return y <= 0.0031308L ? 12.92L * y : 1.055L * std::pow(y, 1.0L / 2.4L) - 0.055L;
}

const std::vector<double> kPositive = {1e-40,  1e-38, 1e-7, 1e-5,  0.003, 0.0031358,
                                       0.0032, 0.5,   1,    65504, 1e30,  3e38};

TEST(ToneMap, AgreesWithLongDouble) {
  const torch::Tensor x = torch::tensor(kPositive, torch::kFloat64);
  const torch::Tensor y = tone_map(x), y32 = tone_map(x.to(torch::kFloat32));
  for (size_t i = 0; i < kPositive.size(); ++i) {
    const auto expected = double(tone_map_reference(kPositive[i]));
    EXPECT_NEAR(y[int64_t(i)].item<double>(), expected, 1e-14 * (1 + expected)) << kPositive[i];
    // In float, x itself is rounded: denormal inputs keep few digits.
    EXPECT_NEAR(y32[int64_t(i)].item<double>(), expected, 4e-7 * expected + 1e-43) << kPositive[i];
  }
}

TEST(ToneMap, NegativeCountsAsZero) {
  const torch::Tensor x = torch::tensor({-0.1, -1.0, -2.0, -3e38, 0.0}, torch::kFloat64);
  EXPECT_TRUE(tone_map(x).eq(0).all().item<bool>());
}

TEST(ToneMap, GradientAgreesWithFiniteDifferences) {
  expect_gradients([](const auto& in) { return tone_map(in[0]); },
                   {variable(torch::tensor({0.001, 0.01, 0.3, 1.0, 7.0, 400.0, -0.5}, torch::kFloat64) +
                             torch::tensor({0., 0., 0., 0., 0., 0., 1.}, torch::kFloat64))});
}

TEST(ToneMap, GradientIsFiniteEverywhere) {
  std::vector<double> values = kPositive;
  for (const double x : kPositive) values.push_back(-x);
  values.push_back(0);
  for (const auto type : {torch::kFloat32, torch::kFloat64}) {
    const torch::Tensor x = torch::tensor(values, torch::kFloat64).to(type).set_requires_grad(true);
    tone_map(x).sum().backward();
    EXPECT_TRUE(all_finite(x.grad()));
    EXPECT_TRUE(x.grad().ge(0).all().item<bool>());
    // The slope from the right at 0 and below, so that a negative value is pulled back.
    EXPECT_NEAR(x.grad()[-1].item<double>(), 12.92, 1e-6);
    EXPECT_NEAR(x.grad()[int64_t(kPositive.size())].item<double>(), 12.92, 1e-6);
  }
}

TEST(ToneMap, KeepsShapeAndType) {
  const torch::Tensor x = random_uniform({2, 3, 5, 7}, 1).to(torch::kFloat32).transpose(2, 3);
  const torch::Tensor y = tone_map(x);
  EXPECT_EQ(y.sizes(), x.sizes());
  EXPECT_EQ(y.scalar_type(), torch::kFloat32);
  EXPECT_FLOAT_EQ(y[1][2][3][4].item<float>(), float(tone_map_reference(x[1][2][3][4].item<float>())));
}

TEST(ToneMap, AnIntegerImageIsAnError) {
  EXPECT_THROW(tone_map(torch::ones({3}, torch::kInt32)), Error);
}

}  // namespace
}  // namespace ld
