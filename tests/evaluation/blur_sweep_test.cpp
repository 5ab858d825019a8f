#include "evaluation/blur_sweep.h"

#include <gtest/gtest.h>

#include <cmath>

#include "evaluation/gaussian_blur.h"
#include "metrics/metric.h"
#include "test_frames.h"

namespace ld {
namespace {

TEST(BlurSweep, GoesFromHalfAPixelToEightInEqualRatios) {
  const std::vector<double>& sigmas = blur_sigmas();
  EXPECT_DOUBLE_EQ(sigmas.front(), 0.5);
  EXPECT_DOUBLE_EQ(sigmas.back(), 8);
  for (size_t i = 1; i < sigmas.size(); ++i) EXPECT_NEAR(sigmas[i] / sigmas[i - 1], std::exp2(0.25), 1e-12);
}

TEST(BlurSweep, ChoosesForEachMetricTheWidthWithTheBestMeanOfTheSet) {
  BlurSweep sweep;
  std::vector<Image> noisy, references;
  for (int i = 0; i < 3; ++i) {
    const EvaluationFrame frame = noisy_frame("", 40, 30, 2, i);
    noisy.push_back(mean_radiance(frame.frame));
    references.push_back(frame.reference);
    sweep.add("f" + std::to_string(i), noisy.back(), references.back(), 2);
  }
  const MethodScores scores = sweep.scores();
  EXPECT_EQ(scores.name, "blur");
  ASSERT_EQ(scores.frames.size(), 3U);
  EXPECT_EQ(scores.frames[2].frame, "f2");
  for (size_t m = 0; m < metrics().size(); ++m) {
    SCOPED_TRACE(metrics()[m].name);
    EXPECT_EQ(scores.sigmas[m], sweep.best_sigma(m));
    // No other width of the sweep has a better mean, and the reported values are those of the chosen one.
    for (const double sigma : blur_sigmas()) {
      double mean = 0;
      for (size_t f = 0; f < 3; ++f)
        mean += metrics()[m].compute(gaussian_blur(noisy[f], sigma), references[f]) / 3;
      EXPECT_FALSE(
          better(metrics()[m], mean - (metrics()[m].best == Best::lowest ? -1e-12 : 1e-12), scores.mean(m)))
          << sigma;
      if (sigma == scores.sigmas[m]) {
        EXPECT_NEAR(mean, scores.mean(m), 1e-12);
      }
    }
  }
}

TEST(BlurSweep, NoiseOnAFlatPictureWantsTheWidestAndDetailTheNarrowest) {
  Image flat(48, 48, 3), noise(48, 48, 3);
  RandomStream stream(6, RandomPurpose::test);
  for (size_t i = 0; i < flat.pixels.size(); ++i) {
    flat.pixels[i] = 0.5F;
    noise.pixels[i] = stream.uniform();
  }
  BlurSweep wide, narrow;
  wide.add("noise", noise, flat, 1);
  narrow.add("detail", noise, noise, 1);
  for (size_t m = 0; m < metrics().size(); ++m) {
    EXPECT_EQ(wide.best_sigma(m), blur_sigmas().back()) << metrics()[m].name;
    EXPECT_EQ(narrow.best_sigma(m), blur_sigmas().front()) << metrics()[m].name;
  }
}

TEST(BlurSweep, EqualWidthsLeaveTheNarrowest) {
  const Image black(12, 12, 3);  // every blur of black is black
  BlurSweep sweep;
  sweep.add("black", black, black, 1);
  for (size_t m = 0; m < metrics().size(); ++m) EXPECT_EQ(sweep.best_sigma(m), blur_sigmas().front());
}

TEST(BlurSweep, TheNumberOfThreadsChangesNoBit) {
  const EvaluationFrame frame = noisy_frame("f", 33, 21, 2, 9);
  BlurSweep one, four;
  one.add("f", mean_radiance(frame.frame), frame.reference, 1);
  four.add("f", mean_radiance(frame.frame), frame.reference, 4);
  EXPECT_EQ(one.scores().frames[0].values, four.scores().frames[0].values);
}

}  // namespace
}  // namespace ld
