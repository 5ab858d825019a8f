// Sequences through the evaluator: whole ones become scores, what stands alone does not.
#include "evaluation/sequence_evaluation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "evaluation/tables.h"
#include "metrics/flip.h"
#include "metrics/statistics.h"
#include "test_frames.h"

namespace ld {
namespace {

/// Three frames of one sequence, a still, two of another sequence.
EvaluationFrame mixed_frame(size_t i) {
  const std::string name = "f" + std::to_string(i);
  if (i == 3) return noisy_frame(name, 24, 20, 2, 3);
  return still_frame(name, 24, 20, i < 3 ? 0 : 1, i < 3 ? int64_t(i) : int64_t(i) - 4);
}

/// One picture for all frames of a sequence: half as bright as the first reference.
Image frozen(const Frame& frame, SequenceState& state) {
  if (!state.memory.has_value()) state.memory = mean_radiance(frame);
  return std::any_cast<Image>(state.memory);
}

size_t place_of_metric(const Evaluation& evaluation, const std::string& name) {
  for (size_t m = 0; m < evaluation.metrics.size(); ++m)
    if (evaluation.metrics[m]->name == name) return m;
  ADD_FAILURE() << "no " << name;
  return 0;
}

TEST(SequenceEvaluation, ScoresWholeSequencesWithTheFramesMeansFirst) {
  EvaluatorOptions options;
  options.sequences = true;
  const auto result = evaluate({6, mixed_frame}, {{"frozen", frozen}}, options);
  ASSERT_TRUE(result && result->sequences);
  const Evaluation& sequences = result->sequences->evaluation;
  EXPECT_EQ(sequences.metrics.size(), 4 + sequence_measures().size());
  const MethodScores &noisy = sequences.method("noisy"), &still = sequences.method("frozen");
  ASSERT_EQ(noisy.frames.size(), 2U) << "the still does not count";
  EXPECT_EQ(noisy.frames[0].frame, "f0 + 2");
  EXPECT_EQ(noisy.frames[1].frame, "f4 + 1");
  const std::vector<FrameScores>& frames = result->method("noisy").frames;
  EXPECT_NEAR(noisy.frames[0].values[3],
              (frames[0].values[3] + frames[1].values[3] + frames[2].values[3]) / 3, 1e-12);
  EXPECT_TRUE(still.frames[0].seconds.has_value());

  const size_t te = place_of_metric(sequences, "te"), steadier = place_of_metric(sequences, "steadier"),
               flicker = place_of_metric(sequences, "flicker");
  EXPECT_GT(noisy.mean(te), 0.05);
  EXPECT_NEAR(still.mean(te), 0, 1e-12);
  EXPECT_NEAR(still.mean(flicker), 0, 1e-7);
  EXPECT_EQ(noisy.mean(steadier), 1);
  EXPECT_GT(sequences.method("blur").mean(steadier), 1);
  EXPECT_TRUE(noisy.values(place_of_metric(sequences, "ghosting")).empty());
  EXPECT_TRUE(mean_interval(noisy.values(te)).has_value()) << "over the two sequences";
}

TEST(SequenceEvaluation, CurvesAreMeansOverTheSequencesThatReachSoFar) {
  EvaluatorOptions options;
  options.sequences = true;
  const auto result = evaluate({6, mixed_frame}, {}, options);
  const std::vector<SequenceCurve>& curves = result->sequences->curves;
  ASSERT_EQ(curves.size(), 3U) << "nothing came into view";
  EXPECT_EQ(curves[0].name, "sequence_error");
  ASSERT_EQ(curves[0].plot.lines.size(), 2U);
  EXPECT_EQ(curves[0].plot.lines[0].points.size(), 3U);
  EXPECT_EQ(curves[1].plot.lines[0].points.size(), 2U) << "the first frame has none before it";
  EXPECT_EQ(curves[1].plot.lines[0].points[0].first, 1);
  EXPECT_EQ(to_svg(curves[0].plot).rfind("<svg", 0), 0U);
}

TEST(SequenceEvaluation, TablesSayWhatTheyAreOver) {
  EvaluatorOptions options;
  options.sequences = true;
  const auto result = evaluate({6, mixed_frame}, {}, options);
  const Evaluation sequences = sequence_scores(*result);
  EXPECT_NE(markdown_means(sequences).find("steadier"), std::string::npos);
  EXPECT_NE(to_csv(sequences).find("\nnoisy,f0 + 2,"), std::string::npos);
  EXPECT_EQ(to_json(*result)["sequences"]["frame_count"], 2);
}

TEST(SequenceEvaluation, WithoutSequencesThereIsNothingToMeasure) {
  EvaluatorOptions options;
  options.sequences = true;
  const FrameSet stills = {2, [](size_t i) { return noisy_frame(std::to_string(i), 8, 8, 1, int(i)); }};
  EXPECT_NE(message_of([&] { evaluate(stills, {}, options); }).find("no two frames of this split follow"),
            std::string::npos);
}

TEST(SequenceEvaluation, ABrokenFrameLeavesItsSequenceWithoutScores) {
  EvaluatorOptions options;
  options.sequences = true;
  const auto broken = [](const Frame& frame, SequenceState& state) {
    Image image = mean_radiance(frame);
    if (state.history() == 2) image.pixels[5] = std::nanf("");
    return image;
  };
  const auto result = evaluate({6, mixed_frame}, {{"broken", broken}}, options);
  const MethodScores& scores = result->sequences->evaluation.method("broken");
  const size_t te = place_of_metric(result->sequences->evaluation, "te");
  EXPECT_TRUE(std::isnan(scores.frames[0].values[te]));
  EXPECT_FALSE(std::isnan(scores.frames[1].values[te]));
  EXPECT_TRUE(std::isnan(scores.mean(te)));
  EXPECT_EQ(scores.not_finite(), 1);
}

TEST(SequenceEvaluation, FurtherMetricsJoinWhereTheyAreAskedFor) {
  EvaluatorOptions options;
  options.metrics = metrics_with({"flip"});
  const auto result = evaluate({2, mixed_frame}, {{"mean", mean_of_samples}}, options);
  for (const MethodScores& method : result->methods)
    EXPECT_EQ(method.frames[1].values.size(), 5U) << method.name;
  EXPECT_EQ(result->method("mean").mean(4), result->method("noisy").mean(4));
  EXPECT_EQ(result->method("noisy").frames[1].values[4],
            flip(mean_radiance(mixed_frame(1).frame), mixed_frame(1).reference));
  EXPECT_GT(result->method("blur").mean(4), 0);
  EXPECT_EQ(result->method("blur").sigmas[4], result->method("blur").sigmas[3]) << "the width of PSNR";
  EXPECT_EQ(to_json(*result)["metrics"]["flip"]["better"], "lower");
}

}  // namespace
}  // namespace ld
