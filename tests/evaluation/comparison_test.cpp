#include "evaluation/comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "test_frames.h"

#include "tests/support/special_values.h"

namespace ld {
namespace {

/// One value for all four metrics of each frame.
MethodScores scores(const std::string& name, const std::vector<double>& values) {
  MethodScores method;
  method.name = name;
  for (size_t f = 0; f < values.size(); ++f)
    method.frames.push_back(
        {"f" + std::to_string(f), {values[f], values[f], values[f], values[f]}, 0, std::nullopt});
  return method;
}

TEST(Comparison, PairsTheFramesSoThatTheirDifficultyCancels) {
  Evaluation evaluation;
  evaluation.methods = {scores("noisy", {0.1, 1, 10, 100, 1000, 1e4}),
                        scores("better", {0.05, 0.95, 9.95, 99.95, 999.95, 9999.95})};
  const Comparison comparison = compare_with(evaluation, evaluation.methods[0]);
  EXPECT_EQ(comparison.baseline, "noisy");
  EXPECT_EQ(comparison.frame_count, 6U);
  EXPECT_FALSE(comparison.too_few_frames());
  ASSERT_EQ(comparison.methods.size(), 1U);
  EXPECT_EQ(comparison.methods[0].name, "better");
  const PairedMetric& relmse = comparison.methods[0].metrics[0];  // lower is better
  EXPECT_NEAR(relmse.mean_difference, -0.05, 1e-9);
  EXPECT_NEAR(relmse.interval->low, -0.05, 1e-9);
  EXPECT_NEAR(relmse.interval->high, -0.05, 1e-9);
  EXPECT_EQ(relmse.better, 6);
  EXPECT_EQ(relmse.worse, 0);
  EXPECT_DOUBLE_EQ(*relmse.p, 2.0 / 64);
  const PairedMetric& psnr = comparison.methods[0].metrics[3];  // higher is better
  EXPECT_EQ(psnr.better, 0);
  EXPECT_EQ(psnr.worse, 6);
}

TEST(Comparison, FramesWithoutAScoreCountAsWorseAndLeaveNoInterval) {
  Evaluation evaluation;
  evaluation.methods = {scores("a", {1, 2, 3}), scores("b", {1, kNan, 4})};
  const Comparison comparison = compare_with(evaluation, evaluation.methods[0]);
  EXPECT_TRUE(comparison.too_few_frames());
  const PairedMetric& paired = comparison.methods[0].metrics[0];
  EXPECT_TRUE(std::isnan(paired.mean_difference));
  EXPECT_FALSE(paired.interval);
  EXPECT_FALSE(paired.p);
  EXPECT_EQ(paired.better, 0);
  EXPECT_EQ(paired.worse, 2);
  EXPECT_EQ(paired.equal, 1);
}

TEST(Comparison, TheBaselineIsTheFirstGivenOrTheNamedOne) {
  Evaluation evaluation;
  evaluation.methods = {scores("noisy", {1}), scores("blur", {1})};
  EXPECT_EQ(evaluation.baseline_method().name, "noisy");
  evaluation.methods.push_back(scores("model", {1}));
  EXPECT_EQ(evaluation.baseline_method().name, "model");
  evaluation.baseline = "blur";
  EXPECT_EQ(evaluation.baseline_method().name, "blur");
  evaluation.baseline = "blurr";
  EXPECT_THROW(evaluation.baseline_method(), UsageError);
  EXPECT_NE(message_of([&] { evaluation.baseline_method(); }).find("there are noisy, blur, model"),
            std::string::npos);
}

TEST(Comparison, OtherNumbersOfFramesAreAnError) {
  Evaluation evaluation;
  evaluation.methods = {scores("a", {1, 2}), scores("b", {1})};
  EXPECT_NE(
      message_of([&] { compare_with(evaluation, evaluation.methods[0]); }).find("b has 1 frames, a has 2"),
      std::string::npos);
}

}  // namespace
}  // namespace ld
