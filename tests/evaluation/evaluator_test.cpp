#include "evaluation/evaluator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <limits>

#include "core/signals.h"
#include "metrics/metric.h"
#include "test_frames.h"

namespace ld {
namespace {

/// Three frames of unequal sizes.
FrameSet three_frames() {
  return {3, [](size_t i) {
            const int number = static_cast<int>(i);
            return noisy_frame("frame_" + std::to_string(i), 24 + 3 * number, 20 - number, 2, number);
          }};
}

Image first_sample(const Frame& frame, SequenceState&) {
  Image image(frame.width, frame.height, 3);
  std::copy(frame.plane(0, 0), frame.plane(0, 3), image.pixels.begin());
  return image;
}

TEST(Evaluator, TellsTheFloorWhereAllReferencesHaveOne) {
  for (const size_t without : {0, 2, 3}) {
    const FrameSet frames = {3, [&](size_t i) {
                               EvaluationFrame frame =
                                   noisy_frame("frame_" + std::to_string(i), 12, 12, 2, static_cast<int>(i));
                               if (i != without)
                                 for (const Metric& metric : metrics())
                                   frame.floor[metric.name] = 0.5 + static_cast<double>(i);
                               return frame;
                             }};
    const auto result = evaluate(frames, {}, {});
    ASSERT_TRUE(result);
    ASSERT_EQ(result->floor.has_value(), without == 3) << without;
    if (!result->floor) continue;
    ASSERT_EQ(result->floor->frames.size(), 3U);
    EXPECT_EQ(result->floor->mean(3), 1.5);
    EXPECT_EQ(result->floor->frames[2].frame, "frame_2");
  }
}

TEST(Evaluator, ScoresBaselinesAndMethodsAsTheMetricsDoFrameByFrame) {
  const FrameSet frames = three_frames();
  const std::vector<Method> methods = {{"first sample", first_sample}, {"mean", mean_of_samples}};
  const auto result = evaluate(frames, methods, {});
  ASSERT_TRUE(result);
  ASSERT_EQ(result->methods.size(), 4U);
  EXPECT_EQ(result->methods[0].name, "noisy");
  EXPECT_EQ(result->methods[1].name, "blur");
  EXPECT_EQ(result->methods[2].name, "first sample");
  SequenceState state;
  for (size_t m = 0; m < metrics().size(); ++m) {
    double sum = 0;
    for (size_t f = 0; f < 3; ++f) {
      const EvaluationFrame frame = frames.load(f);
      const double noisy = metrics()[m].compute(mean_radiance(frame.frame), frame.reference);
      const double first = metrics()[m].compute(first_sample(frame.frame, state), frame.reference);
      EXPECT_EQ(result->method("noisy").frames[f].values[m], noisy);
      EXPECT_EQ(result->method("mean").frames[f].values[m], noisy);
      EXPECT_EQ(result->method("first sample").frames[f].values[m], first);
      EXPECT_EQ(result->method("first sample").frames[f].frame, frame.name);
      sum += first;
    }
    EXPECT_NEAR(result->method("first sample").mean(m), sum / 3, 1e-12);
    // The frames are smooth and noisy, so the best blur beats their mean, and the mean one of its two
    // samples.
    EXPECT_TRUE(better(metrics()[m], result->method("blur").mean(m), result->method("noisy").mean(m)));
    EXPECT_TRUE(
        better(metrics()[m], result->method("noisy").mean(m), result->method("first sample").mean(m)));
  }
}

TEST(Evaluator, TimesTheMethodsAndNotTheBaselines) {
  const auto result = evaluate(three_frames(), {{"mean", mean_of_samples}}, {});
  EXPECT_FALSE(result->method("noisy").mean_seconds());
  EXPECT_FALSE(result->method("blur").mean_seconds());
  ASSERT_TRUE(result->method("mean").mean_seconds());
  EXPECT_GT(*result->method("mean").mean_seconds(), 0);
}

TEST(Evaluator, HandsOutThePicturesOfEachFrameInOrder) {
  EvaluatorOptions options;
  std::vector<std::string> seen;
  options.on_pictures = [&](size_t i, const std::string& name, const std::vector<LabelledPicture>& pictures) {
    std::string line = std::to_string(i) + " " + name + ":";
    for (const LabelledPicture& picture : pictures) {
      line += " " + picture.label;
      EXPECT_EQ(picture.image.width, pictures.front().image.width);
    }
    seen.push_back(line);
  };
  ASSERT_TRUE(evaluate(three_frames(), {{"a", mean_of_samples}, {"b", first_sample}}, options));
  EXPECT_EQ(seen, (std::vector<std::string>{"0 frame_0: noisy blur a b reference",
                                            "1 frame_1: noisy blur a b reference",
                                            "2 frame_2: noisy blur a b reference"}));
}

/// What it did at each frame: "a" alone, "a b" where it remembers a at b.
Method remembering(const std::string& name, std::vector<std::string>& seen) {
  return {
      name, [name, &seen](const Frame& frame, SequenceState& state) {
        const std::string before = state.memory.has_value() ? std::any_cast<std::string>(state.memory) : "";
        state.memory = before + (before.empty() ? "" : " ") + frame.info.scene;
        seen.push_back(name + ": " + std::any_cast<std::string>(state.memory));
        EXPECT_EQ(state.history(), std::count(before.begin(), before.end(), ' ') + (before.empty() ? 0 : 1));
        return mean_radiance(frame);
      }};
}

TEST(Evaluator, GivesEachMethodItsOwnStateThatRestartsAtHoles) {
  const std::vector<std::optional<SequencePlace>> places = {
      SequencePlace{0, 0}, SequencePlace{0, 1}, SequencePlace{0, 3}, SequencePlace{1, 4},
      SequencePlace{1, 5}, std::nullopt,        std::nullopt,        SequencePlace{1, 6}};
  const FrameSet frames = {places.size(), [&](size_t i) {
                             EvaluationFrame frame = noisy_frame("", 12, 12, 1, static_cast<int>(i));
                             frame.frame.info.scene = std::to_string(i);
                             frame.in_sequence = places[i];
                             return frame;
                           }};
  std::vector<std::string> seen;
  const std::vector<Method> methods = {remembering("a", seen), remembering("b", seen)};
  ASSERT_TRUE(evaluate(frames, methods, {}));
  EXPECT_EQ(seen,
            (std::vector<std::string>{"a: 0", "b: 0", "a: 0 1", "b: 0 1", "a: 2", "b: 2", "a: 3", "b: 3",
                                      "a: 3 4", "b: 3 4", "a: 5", "b: 5", "a: 6", "b: 6", "a: 7", "b: 7"}));
}

TEST(Evaluator, ABrokenPictureIsCountedAndSpoilsTheMeanInsteadOfHiding) {
  const auto broken_on_second = [](const Frame& frame, SequenceState&) {
    Image image = mean_radiance(frame);
    if (frame.width == 27) image.pixels[4] = image.pixels[9] = std::numeric_limits<float>::quiet_NaN();
    return image;
  };
  const auto result = evaluate(three_frames(), {{"broken", broken_on_second}}, {});
  const MethodScores& scores = result->method("broken");
  EXPECT_EQ(scores.not_finite(), 2);
  EXPECT_EQ(scores.frames[1].not_finite, 2);
  for (size_t m = 0; m < metrics().size(); ++m) {
    EXPECT_TRUE(std::isnan(scores.frames[1].values[m]));
    EXPECT_TRUE(std::isfinite(scores.frames[0].values[m]));
    EXPECT_TRUE(std::isnan(scores.mean(m)));
    EXPECT_TRUE(std::isfinite(result->method("blur").mean(m)));
  }
}

TEST(Evaluator, SizesThatDifferNameFrameAndMethod) {
  const auto small = [](const Frame&, SequenceState&) { return Image(5, 4, 3); };
  const std::string denoised = message_of([&] { evaluate(three_frames(), {{"small", small}}, {}); });
  EXPECT_NE(denoised.find("small, frame frame_0: the denoised picture is 5x4, its reference 24x20"),
            std::string::npos)
      << denoised;
  const FrameSet wrong_reference = {1, [](size_t) {
                                      EvaluationFrame frame = noisy_frame("odd", 8, 8, 1, 0);
                                      frame.reference = Image(8, 9, 3);
                                      return frame;
                                    }};
  const std::string reference = message_of([&] { evaluate(wrong_reference, {}, {}); });
  EXPECT_NE(reference.find("frame odd: "), std::string::npos) << reference;
  EXPECT_NE(reference.find("8x8, its reference 8x9"), std::string::npos) << reference;
}

TEST(EvaluatorDeathTest, AStopSignalEndsItAfterTheFrameWithoutAResult) {
  // In a process of its own, because the stop flag stays set.
  const auto evaluate_and_exit = [](size_t stop_at) {
    install_stop_handler();
    size_t loaded = 0;
    FrameSet frames = three_frames();
    const auto load = frames.load;
    frames.load = [&](size_t i) {
      if (++loaded == stop_at) std::raise(SIGTERM);
      return load(i);
    };
    const bool finished = evaluate(frames, {}, {}).has_value();
    std::_Exit(finished ? 1 : 10 + static_cast<int>(loaded));
  };
  EXPECT_EXIT(evaluate_and_exit(2), testing::ExitedWithCode(12), "");  // while the blur is chosen
  EXPECT_EXIT(evaluate_and_exit(4), testing::ExitedWithCode(14), "");  // while the frames are scored
  EXPECT_EXIT(evaluate_and_exit(7), testing::ExitedWithCode(1), "");   // never
}

TEST(Evaluator, AnEmptySetAndBadNamesAreErrors) {
  EXPECT_NE(message_of([] { evaluate({0, nullptr}, {}, {}); }).find("no frame"), std::string::npos);
  EXPECT_THROW(evaluate(three_frames(), {{"noisy", mean_of_samples}}, {}), UsageError);
  EXPECT_THROW(evaluate(three_frames(), {{"a", mean_of_samples}, {"a", mean_of_samples}}, {}), UsageError);
}

}  // namespace
}  // namespace ld
