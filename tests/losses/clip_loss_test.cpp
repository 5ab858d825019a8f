// Losses over clips against their equations, against values printed by their source, and their gradients.
#include "losses/clip_loss.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/tone_map.h"
#include "tests/support/expect_error.h"
#include "tests/support/gradient_check.h"

namespace ld {
namespace {

using torch::Tensor;

constexpr int64_t kFrames = 7;

const ClipLossConfig kPublished = {0.8, 0.1, 0.1, 2};
const ClipLossConfig kGradientAlone = {0, 1, 0, 0};
const ClipLossConfig kTemporalAlone = {0, 0, 1, 0};

double value_of(const ClipLossConfig& config, const Tensor& denoised, const Tensor& reference) {
  return make_clip_loss(config, make_loss("l1"))(denoised, reference, kFrames).item<double>();
}

/// Two clips of 17x19 pixels.
Tensor pictures(uint32_t seed) {
  return random_uniform({2 * kFrames, 3, 17, 19}, seed, 0.1, 3);
}

/// Linear values that tone map to these within [0, 1].
Tensor unmapped(const Tensor& mapped) {
  const Tensor y = at::where(mapped.le(0.04045), mapped / 12.92, ((mapped + 0.055) / 1.055).pow(2.4));
  return y.exp() - 1;
}

double tone(const Tensor& picture, int64_t f, int64_t c, int64_t y, int64_t x) {
  return tone_map(picture[f][c][y][x].item<double>());
}

/// The equations, a pixel at a time, of one clip.
double reference_value(const ClipLossConfig& config, const Tensor& d, const Tensor& r, int64_t first) {
  const Tensor kernel = laplacian_of_gaussian(torch::kFloat64);
  const int64_t h = d.size(2), w = d.size(3);
  double sum = 0, weights = 0;
  for (int64_t f = 0; f < kFrames; ++f) {
    double spatial = 0, gradient = 0, temporal = 0;
    const auto difference = [&](int64_t frame, int64_t c, int64_t y, int64_t x) {
      return tone(d, first + frame, c, y, x) - tone(r, first + frame, c, y, x);
    };
    for (int64_t c = 0; c < 3; ++c)
      for (int64_t y = 0; y < h; ++y)
        for (int64_t x = 0; x < w; ++x) {
          spatial += std::abs((d[first + f][c][y][x] - r[first + f][c][y][x]).item<double>());
          if (f > 0) temporal += std::abs(difference(f, c, y, x) - difference(f - 1, c, y, x));
          if (y < 7 || x < 7 || y >= h - 7 || x >= w - 7) continue;
          double edge = 0;
          for (int64_t v = 0; v < 15; ++v)
            for (int64_t u = 0; u < 15; ++u)
              edge += kernel[v][u].item<double>() * difference(f, c, y + v - 7, x + u - 7);
          gradient += std::abs(edge);
        }
    const double all = double(3 * h * w), inside = double(3 * (h - 14) * (w - 14));
    const double before_last = double(kFrames - 1 - f), weight = std::exp(-before_last * before_last / 8);
    sum += weight * (config.spatial * spatial / all + config.gradient * gradient / inside +
                     config.temporal * temporal / all);
    weights += weight;
  }
  return sum / weights;
}

// Chaitanya et al. 2017 print .011 .044 .135 .325 .607 .882 1.
TEST(ClipLoss, TheWeightsOfFramesAreThoseOfThePaper) {
  const std::vector<double> expected = {.011, .044, .135, .325, .607, .882, 1};
  const std::vector<double> weights = frame_weights(kFrames, 2);
  for (size_t f = 0; f < expected.size(); ++f) EXPECT_NEAR(weights[f], expected[f], 5e-4) << f;
  EXPECT_EQ(frame_weights(3, 0), std::vector<double>(3, 1));
}

TEST(ClipLoss, TheKernelOfTheGradientTermIsTheLaplacianOfAGaussian) {
  const Tensor kernel = laplacian_of_gaussian(torch::kFloat64);
  EXPECT_NEAR(kernel[7][7].item<double>(), -0.0628760, 1e-7);
  EXPECT_NEAR(kernel[7][8].item<double>(), -0.0391589, 1e-7);
  EXPECT_NEAR(kernel[9][7].item<double>(), -0.0028721, 1e-7);
  EXPECT_NEAR(kernel[7][4].item<double>(), 0.0085094, 1e-7);
  EXPECT_NEAR(kernel.sum().item<double>(), 0, 1e-15);
  EXPECT_NEAR(kernel.abs().sum().item<double>(), 0.641177, 1e-6);
  const Tensor x = torch::arange(15, torch::kFloat64);
  EXPECT_NEAR((kernel * x.square()).sum().item<double>(), 1.99987, 1e-5);
}

TEST(ClipLoss, AgreesWithItsEquations) {
  const Tensor d = pictures(1), r = pictures(2);
  const double expected =
      0.5 * (reference_value(kPublished, d, r, 0) + reference_value(kPublished, d, r, kFrames));
  EXPECT_NEAR(value_of(kPublished, d, r) / expected, 1, 1e-12);
  EXPECT_NEAR(value_of(kPublished, d.to(torch::kFloat32), r.to(torch::kFloat32)) / expected, 1, 1e-5);
}

TEST(ClipLoss, APlainOneIsTheLossOfAllFramesBitForBit) {
  const Tensor d = pictures(1).to(torch::kFloat32), r = pictures(2).to(torch::kFloat32);
  const Loss loss = make_loss("smape");
  EXPECT_TRUE(make_clip_loss({}, loss)(d, r, kFrames).equal(loss(d, r)));
}

TEST(ClipLoss, TheGradientTermDoesNotSeeConstantsAndRamps) {
  const Tensor mapped = random_uniform({2 * kFrames, 3, 17, 19}, 3, 0.1, 0.5);
  const Tensor ramp = torch::arange(19, torch::kFloat64) * 0.01 +
                      (torch::arange(17, torch::kFloat64) * 0.005).unsqueeze(1) + 0.1;
  EXPECT_NEAR(value_of(kGradientAlone, unmapped(mapped + ramp), unmapped(mapped)), 0, 1e-12);
  EXPECT_GT(value_of(kGradientAlone, unmapped(mapped + ramp.square()), unmapped(mapped)), 1e-6);
}

TEST(ClipLoss, TheTemporalTermDoesNotSeeErrorsThatStay) {
  const Tensor mapped = random_uniform({2 * kFrames, 3, 17, 19}, 3, 0.1, 0.5),
               error = random_uniform({1, 3, 17, 19}, 4, 0, 0.3);
  EXPECT_NEAR(value_of(kTemporalAlone, unmapped(mapped + error), unmapped(mapped)), 0, 1e-12);
  // One frame differs: it counts when it comes and when it goes.
  Tensor flash = mapped.clone();
  flash[3] += 0.1;
  EXPECT_NEAR(value_of(kTemporalAlone, unmapped(flash), unmapped(mapped)), 2 * 0.1 / 2 / kFrames, 1e-12);
}

TEST(ClipLoss, GradientsAgreeWithFiniteDifferences) {
  const Tensor r = pictures(2);
  for (const ClipLossConfig& config : {kPublished, kGradientAlone, kTemporalAlone})
    expect_gradients(
        [&](const auto& v) { return make_clip_loss(config, make_loss("smape"))(v[0], r, kFrames); },
        {variable(pictures(1))});
}

TEST(ClipLoss, StaysFiniteAtTheExtremes) {
  for (const double d : {0.0, 1e-40, 1e-38, 65504.0, 3e38})
    for (const double r : {0.0, 1e-38, 65504.0, 3e38}) {
      Tensor denoised = torch::full({kFrames, 3, 15, 15}, d, torch::kFloat32);
      denoised[2] = torch::full({3, 15, 15}, r, torch::kFloat32);
      denoised.set_requires_grad(true);
      const Tensor loss = make_clip_loss(kPublished, make_loss("smape"))(
          denoised, torch::full({kFrames, 3, 15, 15}, r, torch::kFloat32), kFrames);
      loss.backward();
      EXPECT_TRUE(all_finite(loss) && all_finite(denoised.grad())) << d << " " << r;
    }
}

TEST(ClipLoss, WhatCannotBeFoldedIsAnError) {
  const ClipLoss loss = make_clip_loss(kPublished, make_loss("smape"));
  EXPECT_ERROR(loss(pictures(1), pictures(2), 4), "14 pictures are not whole clips of 4");
  const Tensor small = torch::ones({2, 3, 14, 20});
  EXPECT_ERROR(loss(small, small, 2), "20x14 pixels; expected at least 15 a side");
}

// Of fifth roots: constant errors cost nothing in the gradient term, static ones nothing in the temporal
// term.
TEST(ClipLoss, InPowersIsOfThePicturesAsTheyAre) {
  const Tensor r = pictures(3), error = random_uniform({1, 3, 17, 19}, 4, 0, 1);
  const auto value = [&](const ClipLossConfig& config, const Tensor& d) {
    return make_clip_loss(config, make_loss("l1"), /*in_powers=*/true)(d, r, kFrames).item<double>();
  };
  EXPECT_LE(value(kGradientAlone, r - 0.7), 1e-12);
  const Tensor ramp = torch::arange(19, torch::kFloat64).view({1, 1, 1, -1}) * 0.3;
  EXPECT_LE(value(kGradientAlone, r + ramp), 1e-12);
  EXPECT_LE(value(kTemporalAlone, r + error), 1e-12);
  EXPECT_GT(value(kGradientAlone, r + error), 1e-3);
  // By hand: 1 everywhere, but for one frame that flashes; its change counts twice.
  Tensor d = r + 1;
  d.select(0, 3) += 1;
  const std::vector<double> w = frame_weights(kFrames, 2);
  double sum = 0;
  for (const double weight : w) sum += weight;
  EXPECT_NEAR(value({1, 0, 0, 2}, d), 0.5 * (1 + (sum + w[3]) / sum), 1e-12);
  EXPECT_NEAR(value({0, 0, 1, 2}, d), 0.5 * (w[3] + w[4]) / sum, 1e-12);
}

TEST(ClipLoss, QuarterTurnsChangeNothing) {
  for (const bool in_powers : {false, true}) {
    const ClipLoss loss = make_clip_loss(kPublished, make_loss("l1"), in_powers);
    const Tensor d = pictures(1), r = pictures(2);
    for (const int64_t turns : {1, 2, 3})
      EXPECT_NEAR(loss(at::rot90(d, turns, {2, 3}), at::rot90(r, turns, {2, 3}), kFrames).item<double>(),
                  loss(d, r, kFrames).item<double>(), 1e-13);
  }
}

}  // namespace
}  // namespace ld
