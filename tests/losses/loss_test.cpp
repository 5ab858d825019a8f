#include "losses/loss.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "core/error.h"
#include "metrics/metric.h"
#include "tests/support/gradient_check.h"
#include "tests/support/plain_losses.h"

namespace ld {
namespace {

using torch::Tensor;

double smape_reference(const Tensor& d, const Tensor& r) {
  const std::vector<double> a(d.data_ptr<double>(), d.data_ptr<double>() + d.numel());
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double b = r.data_ptr<double>()[i];
    sum += std::abs(a[i] - b) / (std::abs(a[i]) + std::abs(b) + 0.01);
  }
  return sum / double(a.size());
}

/// By loops over pixels: means of 2x2, what lies beyond an odd border being the border again.
double smape_multiscale_reference(const Tensor& d, const Tensor& r) {
  const auto halved = [](const Tensor& fine) {
    const int64_t h = fine.size(-2), w = fine.size(-1);
    const Tensor planes = fine.reshape({-1, h, w});
    Tensor coarse = torch::zeros({planes.size(0), (h + 1) / 2, (w + 1) / 2}, torch::kFloat64);
    for (int64_t p = 0; p < coarse.size(0); ++p)
      for (int64_t y = 0; y < coarse.size(1); ++y)
        for (int64_t x = 0; x < coarse.size(2); ++x)
          for (int64_t i = 0; i < 4; ++i)
            coarse[p][y][x] += planes[p][std::min(2 * y + i / 2, h - 1)][std::min(2 * x + i % 2, w - 1)] / 4;
    return coarse;
  };
  const Tensor d2 = halved(d), r2 = halved(r), d4 = halved(d2), r4 = halved(r2);
  return (smape_reference(d, r) + smape_reference(d2, r2) + smape_reference(d4, r4) +
          smape_reference(halved(d4), halved(r4))) /
         4;
}

double l2_reference(const Tensor& d, const Tensor& r) {
  const auto tone = [](double x) {
    const double y = std::log(x + 1);
    return y <= 0.0031308 ? 12.92 * y : 1.055 * std::pow(y, 1 / 2.4) - 0.055;
  };
  double sum = 0;
  for (int64_t i = 0; i < d.numel(); ++i)
    sum += std::pow(tone(d.data_ptr<double>()[i]) - tone(r.data_ptr<double>()[i]), 2);
  return sum / double(d.numel());
}

double smape_l2_reference(const Tensor& d, const Tensor& r) {
  return smape_reference(d, r) + l2_reference(d, r);
}

double l1_reference(const Tensor& d, const Tensor& r) {
  double sum = 0;
  for (int64_t i = 0; i < d.numel(); ++i) sum += std::abs(d.data_ptr<double>()[i] - r.data_ptr<double>()[i]);
  return sum / double(d.numel());
}

double relmse_reference(const Tensor& d, const Tensor& r) {
  double sum = 0;
  for (int64_t i = 0; i < d.numel(); ++i) {
    const double a = d.data_ptr<double>()[i], b = r.data_ptr<double>()[i];
    sum += (a - b) * (a - b) / (b * b + 1e-4);
  }
  return sum / double(d.numel());
}

/// Factors on d - r that two losses hold fixed.
double relative_factor(double d) {
  return 1 / std::sqrt(d * d + 0.01);
}

double tone_map_factor(double d) {
  if (d <= 0) return 12.92;
  const double y = std::log(d + 1);
  return (y <= 0.0031308 ? 12.92 : 1.055 / 2.4 * std::pow(y, 1 / 2.4 - 1)) / (d + 1);
}

template <double (*factor)(double)>
double held_factor_reference(const Tensor& d, const Tensor& r) {
  double sum = 0;
  for (int64_t i = 0; i < d.numel(); ++i) {
    const double a = d.data_ptr<double>()[i], b = r.data_ptr<double>()[i];
    sum += std::pow(factor(a) * (a - b), 2);
  }
  return sum / double(d.numel());
}

TEST(Losses, AgreeWithTheirEquations) {
  const std::map<std::string, double (*)(const Tensor&, const Tensor&)> equations = {
      {"l1", l1_reference},
      {"l2_tonemapped", l2_reference},
      {"l2_tonemapped_linear", held_factor_reference<tone_map_factor>},
      {"relative_l2", held_factor_reference<relative_factor>},
      {"relmse", relmse_reference},
      {"smape", smape_reference},
      {"smape_l2", smape_l2_reference},
      {"smape_multiscale", smape_multiscale_reference}};
  const Tensor d = random_uniform({2, 3, 5, 7}, 1, 0, 3), r = random_uniform({2, 3, 5, 7}, 2, 0, 3);
  for (const std::string& name : loss_names()) {
    ASSERT_EQ(equations.count(name), 1) << "no equation to compare loss " << name << " with";
    const double expected = equations.at(name)(d, r);
    const Loss loss = make_loss(name);
    EXPECT_NEAR(loss(d, r).item<double>() / expected, 1, 1e-13) << name;
    EXPECT_NEAR(loss(d.to(torch::kFloat32), r.to(torch::kFloat32)).item<double>() / expected, 1, 3e-6)
        << name;
  }
}

TEST(Losses, HandValues) {
  const Tensor d = torch::tensor({1.0, 0.0}, torch::kFloat64), r = torch::tensor({3.0, 0.0}, torch::kFloat64);
  EXPECT_NEAR(make_loss("smape")(d, r).item<double>(), 2 / 4.01 / 2, 1e-15);
  EXPECT_EQ(make_loss("l2_tonemapped")(d, d).item<double>(), 0);
  EXPECT_EQ(make_loss("l1")(d, r).item<double>(), 1);
  EXPECT_NEAR(make_loss("relmse")(d, r).item<double>(), 4 / 9.0001 / 2, 1e-15);
}

// One definition of the epsilons: a loss is its metric where that is within the loss's bounds.
TEST(Losses, RelmseAndSmapeAreTheMetricsOfTheSameName) {
  const Tensor d = random_uniform({3, 6, 7}, 5, 0, 2), r = random_uniform({3, 6, 7}, 6, 0, 2).pow(8);
  Image a(7, 6, 3), b(7, 6, 3);
  for (int64_t i = 0; i < d.numel(); ++i) {
    a.pixels[size_t(i)] = float(d.data_ptr<double>()[i]);
    b.pixels[size_t(i)] = float(r.data_ptr<double>()[i]);
  }
  for (const char* name : {"relmse", "smape"}) {
    const double loss = make_loss(name)(d, r).item<double>();
    EXPECT_NEAR(loss / find_metric(name).compute(a, b), 1, 1e-6) << name;
  }
}

TEST(Losses, LargeErrorsDoNotOverflowTheSum) {
  const Tensor huge = torch::full({1, 3, 16, 16}, 3e38F), black = torch::zeros({1, 3, 16, 16});
  EXPECT_NEAR(make_loss("l1")(huge, black).item<double>() / 3e38, 1, 1e-6);
  EXPECT_EQ(make_loss("l1")(huge, -huge).item<float>(), std::numeric_limits<float>::max());
  EXPECT_NEAR(make_loss("relmse")(huge, black).item<double>() / 1e16, 1, 1e-6);
  // What half floats can hold keeps its value and its gradient.
  const Tensor firefly = torch::full({1, 3, 1, 1}, 65504.0F).set_requires_grad(true);
  const Tensor loss = make_loss("relmse")(firefly, torch::zeros({1, 3, 1, 1}));
  loss.backward();
  EXPECT_NEAR(loss.item<double>() / (65504.0 * 65504.0 * 1e4), 1, 1e-6);
  EXPECT_NEAR(firefly.grad()[0][0][0][0].item<double>() / (2 * 65504.0 * 1e4 / 3), 1, 1e-6);
}

TEST(Losses, AFactorThatIsHeldFixedTakesNoPartInTheGradient) {
  const std::map<std::string, double (*)(double)> factors = {{"l2_tonemapped_linear", tone_map_factor},
                                                             {"relative_l2", relative_factor}};
  const Tensor values = torch::tensor({-2.0, 0.0, 1e-12, 1e-3, 0.3, 1.0, 50.0, 65504.0}, torch::kFloat64);
  const Tensor d = variable(values.repeat({8})), r = values.repeat_interleave(8);
  for (const std::string& name : losses_with_held_parts()) {
    Tensor input = d.detach().clone().set_requires_grad(true);
    make_loss(name)(input, r).backward();
    for (int64_t i = 0; i < d.numel(); ++i) {
      const double a = d[i].item<double>(), b = r[i].item<double>(), factor = factors.at(name)(a);
      const double expected = 2 * factor * factor * (a - b) / double(d.numel());
      EXPECT_NEAR(input.grad()[i].item<double>(), expected, 1e-12 * std::abs(expected)) << name << " " << a;
    }
  }
}

/// What a constant comes to that is fitted to exponential noise of mean 1 (of which these are the quantiles,
/// strewn over a picture): steps against the sign of the gradient, each a little shorter.
double fitted_to_noise(const std::string& name) {
  constexpr int64_t kTargets = 4096;
  const Tensor order = random_uniform({kTargets}, 9, 0, 1).argsort();
  const Tensor quantiles = (order.to(torch::kFloat64) + 0.5) / double(kTargets);
  const Tensor targets = -torch::log1p(-quantiles).view({64, 64});
  const Loss loss = make_loss(name);
  Tensor constant = torch::full({1}, 2.0, torch::kFloat64).set_requires_grad(true);
  for (double step = 0.2; step > 1e-6; step *= 0.98) {
    loss(constant.expand({64, 64}), targets).backward();
    const torch::NoGradGuard no_graph;
    constant -= step * constant.grad().sign();
    constant.mutable_grad().reset();
  }
  return constant.item<double>();
}

// What docs/training.md says of training on references of few samples. The median of the noise is log 2.
TEST(Losses, OfNoisyTargetsOnlyTheLossesMadeForThemFindTheMean) {
  const std::map<std::string, double> expected = {{"l1", std::log(2)},         {"l2_tonemapped", 0.643},
                                                  {"l2_tonemapped_linear", 1}, {"relative_l2", 1},
                                                  {"relmse", 0.0266},          {"smape", 0.784},
                                                  {"smape_l2", 0.728},         {"smape_multiscale", 0.964}};
  for (const std::string& name : loss_names()) {
    ASSERT_EQ(expected.count(name), 1) << "what does loss " << name << " make of noisy targets?";
    EXPECT_NEAR(fitted_to_noise(name) / expected.at(name), 1, 0.01) << name;
  }
}

TEST(Losses, ForSmallErrorsTheLinearisedLossIsTheToneMappedOne) {
  const Tensor r = random_uniform({1, 3, 8, 8}, 7, 0.05, 20),
               d = r * (1 + 1e-4 * random_normal({1, 3, 8, 8}, 8));
  EXPECT_NEAR((make_loss("l2_tonemapped_linear")(d, r) / make_loss("l2_tonemapped")(d, r)).item<double>(), 1,
              1e-3);
}

// Every registered loss, also the one that is added tomorrow.
TEST(Losses, GradientsAgreeWithFiniteDifferences) {
  const Tensor r = random_uniform({1, 3, 4, 4}, 4, 0, 2);
  for (const std::string& name : plain_losses())
    expect_gradients([&](const auto& v) { return make_loss(name)(v[0], r); },
                     {variable(random_uniform({1, 3, 4, 4}, 3, 0.1, 3))});
}

TEST(Losses, StayFiniteOnTheirWholeDomain) {
  const std::vector<double> values = {0, 1e-40, 1e-38, 1e-3, 1, 65504, 1e30, 3e38, -1e-40, -100, -3e38};
  for (const std::string& name : loss_names())
    for (const double d : values)
      for (const double r : values) {
        const Tensor denoised = torch::full({1, 3, 2, 2}, d, torch::kFloat32).set_requires_grad(true);
        const Tensor loss = make_loss(name)(denoised, torch::full({1, 3, 2, 2}, r, torch::kFloat32));
        loss.backward();
        EXPECT_TRUE(all_finite(loss) && all_finite(denoised.grad())) << name << " " << d << " " << r;
        EXPECT_GE(loss.item<double>(), 0) << name;
        if (d == r) {
          EXPECT_EQ(loss.item<double>(), 0) << name << " " << d;
        }
      }
}

TEST(Losses, UnknownNamesAndUnequalShapesAreErrors) {
  try {
    make_loss("smap");
    FAIL() << "accepted an unknown loss";
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(),
                 "unknown loss 'smap'; did you mean 'smape'? choose from l1, l2_tonemapped, "
                 "l2_tonemapped_linear, relative_l2, relmse, smape, smape_l2, smape_multiscale");
  }
  for (const std::string& name : loss_names()) {
    EXPECT_THROW(make_loss(name)(torch::ones({1, 3, 2, 2}), torch::ones({1, 3, 2, 1})), Error);
    EXPECT_THROW(make_loss(name)(torch::ones({1, 3, 2, 2}), torch::ones({1, 3, 2, 2}, torch::kFloat64)),
                 Error);
  }
}

}  // namespace
}  // namespace ld
