// The measures of sequences on sequences whose scores are known.
#include "metrics/sequence_meter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/random.h"
#include "core/tone_map.h"
#include "metrics/psnr.h"

namespace ld {
namespace {

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
enum Place { te, tpsnr, trmae, flicker, steadier, ghosting, trail, first_frame, detail };

/// Radiance that is shown as y in (0.04045, 1).
float radiance(double y) {
  return static_cast<float>(std::expm1(std::pow((y + 0.055) / 1.055, 2.4)));
}

/// A wall in front of the camera that moves by `flow` pixels a frame.
SurfaceGuides facing_wall(int width, int height, float flow_x = 0) {
  SurfaceGuides guides;
  guides.width = width;
  guides.height = height;
  guides.has_flow = true;
  const size_t count = size_t(width) * size_t(height);
  guides.surface.assign(count, SeenSurface{1, 0, 0, 1, 0});
  guides.depth.assign(count, 1);
  guides.flow_x.assign(count, flow_x);
  guides.flow_y.assign(count, 0);
  guides.flow_z.assign(count, 0);
  return guides;
}

/// A picture whose pixel (c, x, y) is shown as value(c, x, y).
Image picture(int width, int height, const std::function<double(int, int, int)>& value) {
  Image image(width, height, 3);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) image.at(c, x, y) = radiance(value(c, x, y));
  return image;
}

double texture(int c, int x, int y) {
  return 0.5 + 0.2 * std::sin(1.1 * x + c) * std::cos(0.9 * y);
}

struct Measured {
  std::vector<double> values;
  std::vector<bool> applies;
  std::vector<SequenceFrame> frames;
};

using Pictures = std::function<Image(int)>;

Measured measure(int length, const std::function<SurfaceGuides(int)>& guides, const Pictures& reference,
                 const Pictures& denoised, const Pictures& noisy) {
  SequenceGround ground;
  SequenceMeter meter, noisy_meter;
  for (int t = 0; t < length; ++t) {
    ground.advance(guides(t), reference(t));
    meter.add(ground, denoised(t));
    noisy_meter.add(ground, noisy(t));
  }
  const SequenceScores scores = meter.scores(ground, noisy_meter);
  return {scores.values, scores.applies, meter.frames()};
}

/// A still shot of a textured wall.
Measured measure_still(int width, int height, int length, const Pictures& denoised) {
  const auto still = [&](int) { return facing_wall(width, height); };
  const Pictures reference = [&](int) { return picture(width, height, texture); };
  return measure(length, still, reference, denoised, denoised);
}

/// The wall's texture with Gaussian noise of `deviation` that differs with `number`.
Image noisy_texture(int width, int height, double deviation, int number) {
  RandomStream stream(3, RandomPurpose::test, static_cast<uint32_t>(number));
  return picture(width, height,
                 [&](int c, int x, int y) { return texture(c, x, y) + deviation * stream.normal(); });
}

TEST(SequenceMeter, APerfectSequenceHasThePerfectScores) {
  const auto perfect = measure_still(20, 18, 6, [](int) { return picture(20, 18, texture); });
  for (size_t m : {te, trmae, flicker}) EXPECT_EQ(perfect.values[m], 0) << m;
  EXPECT_EQ(perfect.values[tpsnr], std::numeric_limits<double>::infinity());
  for (size_t m : {steadier, first_frame, detail}) EXPECT_EQ(perfect.values[m], 1) << m;
  EXPECT_FALSE(perfect.applies[ghosting]) << "nothing came into view";
}

TEST(SequenceMeter, AStaticBiasIsNoTemporalError) {
  const auto biased = measure_still(20, 18, 5, [](int) {
    return picture(20, 18, [](int c, int x, int y) { return texture(c, x, y) + 0.1; });
  });
  EXPECT_NEAR(biased.values[te], 0, 1e-12);
  EXPECT_NEAR(biased.values[flicker], 0, 1e-7);
  EXPECT_NEAR(biased.frames[3].error, 0.1, 1e-6);
}

TEST(SequenceMeter, IndependentNoiseOfVarianceSHasTwiceItsSquareBetweenFrames) {
  constexpr double s = 0.05;
  const auto noisy = measure_still(64, 48, 6, [](int t) { return noisy_texture(64, 48, s, t); });
  const double squared = std::pow(10, -noisy.values[tpsnr] / 10);
  EXPECT_NEAR(squared / (2 * s * s), 1, 0.02);
  EXPECT_NEAR(noisy.values[te] / (2 * s / std::sqrt(std::acos(-1.0))), 1, 0.02) << "mean |N(0, 2 s^2)|";
  EXPECT_NEAR(noisy.values[flicker] / (s * 0.9515), 1, 0.02) << "the mean deviation of six";
  EXPECT_NEAR(noisy.values[first_frame], 1, 0.03);
  EXPECT_GT(noisy.values[detail], 1) << "noise is more than there was";
}

TEST(SequenceMeter, FrozenNoiseIsNoTemporalErrorButStaysOneOfPictures) {
  const Image frozen = noisy_texture(32, 32, 0.05, 1), reference = picture(32, 32, texture);
  const auto measured = measure_still(32, 32, 4, [&](int) { return frozen; });
  EXPECT_EQ(measured.values[tpsnr], std::numeric_limits<double>::infinity());
  EXPECT_EQ(measured.values[te], 0);
  EXPECT_NEAR(psnr(frozen, reference), 26, 0.3);
}

TEST(SequenceMeter, AFlashOfOneFrameCountsTwice) {
  const auto flash = [](int at) {
    return measure_still(16, 16, 6, [at](int t) {
      return picture(16, 16, [&](int c, int x, int y) { return texture(c, x, y) + (t == at ? 0.2 : 0); });
    });
  };
  const auto within = flash(3), at_the_end = flash(5);
  EXPECT_NEAR(within.values[te] / at_the_end.values[te], 2, 1e-5);
  EXPECT_NEAR(within.values[te], 2 * 0.2 / 5, 1e-6);
  EXPECT_NEAR(within.values[tpsnr] - at_the_end.values[tpsnr], -10 * std::log10(2.0), 1e-4);
}

TEST(SequenceMeter, BlurLosesDetail) {
  const auto flat =
      measure_still(40, 40, 3, [](int) { return picture(40, 40, [](int, int, int) { return 0.5; }); });
  EXPECT_NEAR(flat.values[detail], 0, 1e-9);
  const auto half = measure_still(40, 40, 3, [](int) {
    return picture(40, 40, [](int c, int x, int y) { return 0.5 + 0.5 * (texture(c, x, y) - 0.5); });
  });
  EXPECT_NEAR(half.values[detail], 0.25, 1e-4);
}

TEST(SequenceMeter, WhatMovesAsTheReferenceDoesIsSteady) {
  // The texture moves by whole pixels, so that warping loses nothing.
  const auto moved = [](int t) {
    return picture(40, 24, [t](int c, int x, int y) { return texture(c, x - 2 * t, y); });
  };
  const auto guides = [](int) { return facing_wall(40, 24, -2); };
  const auto steady = measure(6, guides, moved, moved, moved);
  EXPECT_EQ(steady.values[te], 0);
  EXPECT_FALSE(steady.applies[flicker]) << "nothing stands still";
  // What stands still on the screen where the reference moves is not.
  const auto stuck = measure(
      6, guides, moved, [&](int) { return moved(0); }, moved);
  EXPECT_GT(stuck.values[te], 0.02);
  EXPECT_EQ(std::isnan(stuck.frames[0].warped), true);
}

TEST(SequenceMeter, GhostsShowWhereSomethingCameIntoView) {
  // A grey wall; a bright plate before its left half goes away at frame 2.
  const auto guides = [](int t) {
    SurfaceGuides result = facing_wall(24, 16);
    for (size_t p = 0; p < result.surface.size(); ++p)
      if (t < 2 && p % 24 < 12) result.surface[p].id = 5;
    return result;
  };
  const auto reference = [](int t) {
    return picture(24, 16, [t](int, int x, int) { return t < 2 && x < 12 ? 0.9 : 0.4; });
  };
  // A filter that keeps half of what it showed before.
  const auto lagging = [](int t) {
    const double ghost = t < 2 ? 0 : 0.5 * std::pow(0.5, t - 2);
    return picture(24, 16,
                   [&](int, int x, int) { return t < 2 && x < 12 ? 0.9 : 0.4 + (x < 12 ? ghost : 0); });
  };
  const auto ghost = measure(10, guides, reference, lagging, reference);
  EXPECT_TRUE(ghost.applies[ghosting]);
  EXPECT_NEAR(ghost.values[ghosting], 240.0 / 96, 1e-9) << "all error lies on 8 of the 10 x 2 halves";
  EXPECT_EQ(ghost.values[trail], 5) << "0.5 / 2^5 / 0.4 < 0.05";
  const auto clean = measure(10, guides, reference, reference, reference);
  EXPECT_EQ(clean.values[ghosting], 1);
  EXPECT_EQ(clean.values[trail], 0);
  EXPECT_FALSE(clean.applies[flicker] && clean.values[flicker] > 0);
}

TEST(SequenceMeter, ALightThatGoesOffIsAChange) {
  const auto still = [](int) { return facing_wall(24, 16); };
  const auto reference = [](int t) {
    return picture(24, 16, [t](int, int, int) { return t < 2 ? 0.8 : 0.3; });
  };
  const auto late = [](int t) { return picture(24, 16, [t](int, int, int) { return t < 3 ? 0.8 : 0.3; }); };
  const auto measured = measure(6, still, reference, late, reference);
  EXPECT_EQ(measured.values[trail], 1);
  EXPECT_FALSE(measured.applies[flicker]) << "the light is not still";
  EXPECT_GT(measured.values[te], 0.1);
}

TEST(SequenceMeter, TheTrailIsToldThroughNoiseOfPictureAndReference) {
  // A lamp goes off at frame 2; both pictures have noise that is a fifth of what light is left.
  const auto still = [](int) { return facing_wall(64, 48); };
  const auto lit = [](int t, double left, int number) {
    RandomStream stream(5, RandomPurpose::test, static_cast<uint32_t>(100 * number + t));
    return picture(64, 48,
                   [&](int, int, int) { return (t < 2 ? 0.8 : 0.3 + 0.5 * left) + 0.06 * stream.normal(); });
  };
  const auto trail_of = [&](double kept) {  // each frame keeps so much of the one before
    const auto lagging = [&](int t) { return lit(t, t < 2 ? 0 : std::pow(kept, t - 1), 1); };
    const auto noisy = [&](int t) { return lit(t, 0, 2); };
    return measure(
               12, still, [&](int t) { return lit(t, 0, 3); }, lagging, noisy)
        .values[trail];
  };
  EXPECT_EQ(trail_of(0), 0);
  EXPECT_EQ(trail_of(0.2), 1) << "0.2^2 < 0.05";
  EXPECT_EQ(trail_of(0.5), 4) << "0.5^5 < 0.05";
  EXPECT_EQ(trail_of(0.8), kChangedFrames);
}

TEST(SequenceMeter, TheFirstFramesErrorStandsBesideThatOfTheLastOnes) {
  const auto better = measure_still(20, 20, 8, [](int t) {
    return picture(20, 20, [t](int c, int x, int y) { return texture(c, x, y) + (t == 0 ? 0.15 : 0.05); });
  });
  EXPECT_NEAR(better.values[first_frame], 3, 1e-4);
}

TEST(SequenceMeter, ExtremesAndOddSizes) {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 3}, {17, 1}, {15, 15}, {33, 17}})
    for (const float extreme :
         {0.0F, std::numeric_limits<float>::denorm_min(), 1e-38F, 65504.0F, 3e38F, -1.0F, -3e38F})
      for (const int length : {1, 2, 5}) {
        SCOPED_TRACE(testing::Message() << width << "x" << height << " " << extreme << " " << length);
        Image flat(width, height, 3);
        for (float& x : flat.pixels) x = extreme;
        const auto still = [w = width, h = height](int) { return facing_wall(w, h); };
        const auto grey = [w = width, h = height](int) { return picture(w, h, texture); };
        for (const bool swapped : {false, true}) {
          const Pictures extreme_picture = [&](int) { return flat; };
          const auto measured = swapped ? measure(length, still, extreme_picture, grey, grey)
                                        : measure(length, still, grey, extreme_picture, grey);
          ASSERT_EQ(measured.values.size(), sequence_measures().size());
          for (size_t m = 0; m < measured.values.size(); ++m)
            EXPECT_EQ(std::isnan(measured.values[m]), !measured.applies[m]) << sequence_measures()[m].name;
          EXPECT_EQ(measured.applies[te], length > 1);
          EXPECT_EQ(measured.applies[first_frame], length >= 4);
        }
      }
}

TEST(SequenceMeter, ABrokenPictureLeavesTheSequenceWithoutScores) {
  for (const float bad : {kNotANumber, std::numeric_limits<float>::infinity()}) {
    const auto reference = [](int) { return picture(18, 18, texture); };
    const auto still = [](int) { return facing_wall(18, 18); };
    const auto measured = measure(
        5, still, reference,
        [&](int t) {
          Image image = reference(t);
          if (t == 2) image.pixels[7] = bad;
          return image;
        },
        reference);
    for (size_t m = 0; m < measured.values.size(); ++m) EXPECT_TRUE(std::isnan(measured.values[m])) << m;
    EXPECT_TRUE(measured.applies[te] && measured.applies[flicker] && measured.applies[detail]);
    EXPECT_FALSE(std::isnan(measured.frames[1].error));
    EXPECT_TRUE(std::isnan(measured.frames[2].error));
  }
}

TEST(SequenceMeter, WithoutFlowOnlyWhatNeedsNoneIsMeasured) {
  const auto blind = [](int) {
    SurfaceGuides guides = facing_wall(18, 18);
    guides.has_flow = false;
    return guides;
  };
  const auto reference = [](int) { return picture(18, 18, texture); };
  const auto measured = measure(5, blind, reference, reference, reference);
  for (size_t m : {te, flicker, steadier, ghosting, trail}) EXPECT_FALSE(measured.applies[m]) << m;
  for (size_t m : {tpsnr, trmae, first_frame, detail}) EXPECT_TRUE(measured.applies[m]) << m;
}

}  // namespace
}  // namespace ld
