#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "ops/kernels/instruction_sets.h"
#include "reference_svgf.h"
#include "svgf_sequence.h"

namespace ld {
namespace {

TEST(Svgf, ConstantSurfacesStayAsTheyAre) {  // 2.9 a
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 90}, {40, 30}}) {
    Surfaces scene = busy_scene(width, height, 3);
    for (int p = 0; p < 3; ++p)
      for (int y = 0; y < height; ++y) std::fill_n(scene.flow.row(y, p), width, 0.0F);
    const RowPlanes light = filled(width, height, 6, [&](int p, int x, int y) {
      return scene.of.at(x, y, kId) == scene.of.at(x, y, kId) ? 1 + scene.of.at(x, y, kId) + 0.1F * float(p)
                                                              : 0.0F;
    });
    Sequence sequence;
    for (int f = 0; f < 7; ++f) {
      const RowPlanes out = sequence(scene, light);
      for (int s = 0; s < 2; ++s)
        for (int c = 0; c < 3; ++c)
          for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
              ASSERT_NEAR(out.at(x, y, 4 * s + c), light.at(x, y, 3 * s + c),
                          2e-6 * light.at(x, y, 3 * s + c));
    }
  }
}

TEST(Svgf, TextureWithoutNoiseComesBackAsTheFirstFramesFade) {  // 2.9 a
  const int side = 40;
  const RowPlanes light =
      filled(side, side, 3, [](int, int x, int y) { return (x / 3 + y / 3) % 2 == 0 ? 1.0F : 0.25F; });
  Sequence sequence;
  sequence.settings.antilag = "none";
  double at_four = 0;
  for (int f = 1; f <= 70; ++f) {
    const RowPlanes out = sequence(flat_wall(side, side), light);
    double error = 0;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x)
        error = std::max(error, double(std::abs(out.at(x, y, 0) - light.at(x, y, 0))));
    if (f == 4) at_four = error;
    // Frames 1 to 3 are blurred; from then on each frame is one fifth of what comes in.
    if (f > 5 && f <= 50) {
      EXPECT_LE(error, at_four * std::pow(0.8, f - 5) + 1e-6) << f;
    }
    if (f == 70) {
      EXPECT_LE(error, 1e-6);
    }
  }
  EXPECT_GT(at_four, 0.05);
}

TEST(Svgf, VarianceFallsAsTheHistoryGrows) {  // 2.9 b
  const int side = 160;
  const Surfaces wall = flat_wall(side, side);
  for (const double alpha : {0.2, 0.05}) {
    SvgfSettings settings = no_feedback();
    settings.alpha = settings.alpha_moments = alpha;
    SvgfState previous;
    RowPlanes slopes, light, moments;
    depth_slopes(wall, slopes, 1);
    const int frames = 150;
    std::vector<double> variances;
    double late = 0;
    for (int f = 0; f < frames; ++f) {
      accumulate(wall, slopes, noise(side, side, 3, uint64_t(f)), previous, settings, light, moments, 1);
      const double variance = spread(light, 0).variance;
      variances.push_back(variance);
      if (f >= 100) late += variance / 50;
      std::swap(previous.light, light);
      std::swap(previous.moments, moments);
      previous.surfaces = wall;
    }
    const int averages = alpha == 0.2 ? 5 : 20;
    for (int f = 0; f < averages; ++f) EXPECT_NEAR(variances[size_t(f)], 1.0 / (f + 1), 0.05 / (f + 1)) << f;
    EXPECT_NEAR(late, alpha / (2 - alpha), 0.05 * alpha / (2 - alpha));  // 0.1111, 0.02564
  }
}

TEST(Svgf, IsUnbiasedOverSeeds) {  // 2.9 c
  const int side = 96;
  const Surfaces wall = flat_wall(side, side);
  SvgfSettings settings = no_feedback();
  double sum = 0, count = 0;
  for (uint64_t seed = 0; seed < 8; ++seed) {
    const auto frames = accumulated(6, settings, [&](int f) {
      return std::pair{wall, noise(side, side, 3, 100 * seed + uint64_t(f), true)};
    });
    sum += spread(frames.back(), 1).mean;
    ++count;
  }
  // Exponential noise of mean and deviation 1: the mean of 8 * 96^2 pixels, each of variance about 0.2.
  EXPECT_NEAR(sum / count, 1, 4 * std::sqrt(0.2 / (8.0 * side * side)));
}

TEST(Svgf, VarianceFollowsTheIndependentTapsOnAFlatWall) {  // 2.9 d
  const int side = 160;
  const Surfaces wall = flat_wall(side, side);
  SvgfSettings settings;
  settings.sigma_light = 1e30;
  RowPlanes slopes, out;
  depth_slopes(wall, slopes, 1);
  RowPlanes in =
      filled(side, side, 4, [](int p, int x, int y) { return p == 3 ? 3.0F : float((x * y) % 7); });
  double expected = 3;
  for (int level = 0; level < 5; ++level) {
    svgf_level(wall, slopes, in, out, level, settings, 1);
    std::swap(in, out);
    expected *= 0.07476806640625;  // ((6^2 + 2 4^2 + 2 1^2) / 16^2)^2
    EXPECT_NEAR(in.at(side / 2, side / 2, 3), expected, 1e-5 * expected) << level;
  }
}

TEST(Svgf, VarianceOfMomentsIsThatOfTheLightUnderTheFilter) {
  // Of taps that are alike it stays, of white noise with hardly any variance of its own it becomes that of
  // the noise.
  SvgfSettings settings = no_feedback();
  settings.variance = "moments";
  settings.sigma_light = 1e20;
  const int side = 256;
  const Surfaces wall = flat_wall(side, side);
  RowPlanes slopes, out;
  depth_slopes(wall, slopes, 1);
  RowPlanes light(side, side, 4);
  fill(light, [](int p, int, int) { return p == 3 ? 0.25F : 2.0F; });
  svgf_level(wall, slopes, light, out, 0, settings, 1);
  EXPECT_NEAR(out.at(100, 100, 3), 0.25, 1e-6);
  const RowPlanes white = noise(side, side, 3, 5);
  fill(light, [&](int p, int x, int y) { return p == 3 ? 1e-12F : white.at(x, y, 0); });
  double input = 0, variance = 0, mean = 0;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) mean += white.at(x, y, 0) / double(side * side);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) input += std::pow(white.at(x, y, 0) - mean, 2) / double(side * side);
  svgf_level(wall, slopes, light, out, 0, settings, 1);
  for (int y = 4; y < side - 4; ++y)
    for (int x = 4; x < side - 4; ++x) variance += out.at(x, y, 3) / double((side - 8) * (side - 8));
  // Taps that are independent are a sample with weights: 1 - sum h^2 of the variance, sum h^2 = 0.074768.
  EXPECT_NEAR(variance / input, 1 - 0.074768, 0.03);
}

TEST(Svgf, WithTheVarianceDividedBySquaresItNeverFalls) {  // 2.9 d, the slip
  ReferenceSvgf slipped;
  slipped.settings.sigma_light = 1e30;
  slipped.variance_slip = true;
  const Surfaces wall = flat_wall(24, 24);
  DoublePlanes light = to_double(noise(24, 24, 3, 1)),
               variance = to_double(filled(24, 24, 1, [](int, int, int) { return 3.0F; }));
  for (int level = 0; level < 3; ++level) slipped.level(wall, slipped.slopes(wall), level, light, variance);
  EXPECT_NEAR(variance[0][12][12], 3, 1e-9);
}

TEST(Svgf, AWireBorrowsTheLightOfItsOtherPixelsUntilItHasAHistory) {
  // A wire of one pixel whose normals have nothing in common, and a dot that nothing resembles; of four
  // samples one brings light.
  const int width = 31, height = 400, column = 10;
  Surfaces scene = flat_wall(width, height);
  RowPlanes signals = filled(width, height, 3, [](int, int, int) { return 1.0F; });
  const RowPlanes chance = noise(1, height, 3, 5);
  double noisy = 0;
  for (int y = 0; y < height; ++y) {
    scene.of.at(column, y, kId) = 2;
    scene.of.at(column, y, kNormalX + y % 3) = 1;
    if (y % 3 != 2) scene.of.at(column, y, kNormalZ) = 0;
    const float lit = chance.at(0, y, 0) > 0.6745F ? 4.0F : 0.0F;
    noisy += (lit - 1.0) * (lit - 1.0) / height;
    for (int c = 0; c < 3; ++c) signals.at(column, y, c) = lit;
  }
  scene.of.at(20, 20, kId) = 3;
  for (int c = 0; c < 3; ++c) signals.at(20, 20, c) = 0.5F;
  SvgfSettings settings = no_feedback();
  RowPlanes slopes, light, moments, spare;
  depth_slopes(scene, slopes, 1);
  accumulate(scene, slopes, signals, {}, settings, light, moments, 1);
  estimate_variance(scene, slopes, moments, light, spare, settings, 1);
  double left = 0;
  for (int y = 3; y + 3 < height; ++y) {
    left += std::pow(double(light.at(column, y, 0)) - 1, 2) / (height - 6);
    ASSERT_FLOAT_EQ(light.at(column - 1, y, 0), 1) << "nothing reaches another surface";
  }
  // w = 1 of its own and of those with its normal, three pixels away (3 of 7 in all): 1 of 4 is lacking,
  // shared among 7.
  const double own = (1 + 1.0 / 7) / 4, others = (1.0 / 7) / 4;
  EXPECT_NEAR(left / noisy, 3 * own * own + 4 * others * others, 0.06);
  EXPECT_EQ(light.at(20, 20, 0), 0.5F);
}

TEST(Svgf, ThreadsAndTilesHaveTheSameBits) {  // 2.9 m
  const int width = 150, height = 230;
  for (const std::string antilag : {"none", "clip"}) {
    SvgfSettings settings;
    settings.antilag = antilag;
    Sequence one{settings, 1}, three{settings, 3}, upper{settings, 1};
    for (int f = 0; f < 5; ++f) {
      Surfaces scene = busy_scene(width, height, uint64_t(f));
      for (int y = 0; y < height; ++y) std::fill_n(scene.flow.row(y, 1), width, 0.0F);
      const RowPlanes signals = noise(width, height, 3, 9 + uint64_t(f), true);
      const RowPlanes a = one(scene, signals);
      ASSERT_TRUE(same_bits(a, three(scene, signals)));
      // A strip of the picture: after f frames its history is that of the whole but for 5 rows a frame (7x7
      // and level 0 reach 3 + 2), and the filter reaches 62 + 3 + 1.
      const RowPlanes part = upper(cut(scene, 0, 0, width, 160), cut(signals, 0, 0, width, 160));
      for (int p = 0; p < 4; ++p)
        for (int y = 0; y < 160 - 66 - 6 * (f + 1); ++y)
          ASSERT_TRUE(std::equal(a.row(y, p), a.row(y, p) + width, part.row(y, p))) << f << " " << y;
    }
  }
}

TEST(Svgf, IsTheEquationsInDoubleOnEveryInstructionSet) {  // 2.9 n
  const int width = 45, height = 37;
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    for (const std::string slope : {"plane", "isotropic"})
      for (const int64_t feedback : {-1, 0, 1}) {
        ReferenceSvgf reference;
        reference.settings.antilag = "none";
        reference.settings.variance = feedback == 1 ? "moments" : "taps";
        reference.settings.slope = slope;
        reference.settings.feedback = feedback;
        ReferenceSvgfState state;
        Sequence sequence{reference.settings};
        for (int f = 0; f < 8; ++f) {
          const Surfaces scene = busy_scene(width, height, uint64_t(f));
          const RowPlanes signals = noise(width, height, 6, 77 + uint64_t(f), true);
          const DoublePlanes expected = reference(scene, signals, state);
          const RowPlanes out = sequence(scene, signals);
          RowPlanes colours(width, height, 6);
          fill(colours, [&](int p, int x, int y) { return out.at(x, y, p / 3 * 4 + p % 3); });
          ASSERT_LE(largest_difference(colours, expected, 1e-3), 1e-4)
              << set << slope << feedback << " " << f;
          for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
              ASSERT_EQ(sequence.length(x, y), state.length[0][size_t(y)][size_t(x)]) << f;
        }
      }
  }
  use_instruction_set("");
}

TEST(Svgf, ExtremeLightAndGuidesStayFinite) {
  const int width = 40, height = 20;
  for (const float value : {0.0F, 1e-45F, 1e-38F, 65504.0F, 1e18F, 1e37F, -3.0F})
    for (const std::string antilag : {"none", "clip"}) {
      SvgfSettings settings;
      settings.antilag = antilag;
      settings.variance = antilag == "none" ? "moments" : "taps";
      Sequence sequence{settings};
      for (int f = 0; f < 6; ++f) {
        Surfaces scene = busy_scene(width, height, uint64_t(f));
        scene.flow.at(3, 3, 0) = 65504;
        scene.flow.at(4, 3, 1) = -65504;
        scene.flow.at(5, 3, 1) = std::numeric_limits<float>::quiet_NaN();
        scene.of.at(6, 6, kDepth) = 0;
        scene.of.at(7, 6, kDepth) = 65504;
        const RowPlanes out = sequence(scene, filled(width, height, 3, [&](int, int x, int y) {
                                         return (x + y + f) % 3 == 0 ? value : 0.0F;
                                       }));
        for (int p = 0; p < 3; ++p)
          for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) ASSERT_TRUE(std::isfinite(out.at(x, y, p))) << value << " " << f;
      }
    }
}

TEST(Svgf, RefusesFeedbackBehindTheLastLevel) {
  Sequence sequence;
  sequence.settings.levels = 2;
  sequence.settings.feedback = 2;
  EXPECT_THROW(sequence(flat_wall(4, 4), RowPlanes(4, 4, 3)), UsageError);
}

}  // namespace
}  // namespace ld
