#include "evaluation/evaluator.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "core/signals.h"
#include "evaluation/blur_sweep.h"
#include "evaluation/gaussian_blur.h"
#include "evaluation/sequence_evaluation.h"
#include "metrics/image_pair.h"
#include "metrics/metric.h"

namespace ld {
namespace {

/// The metrics' complaints know no names; this adds them.
FrameScores score(const std::string& method, const std::string& frame, const Image& image,
                  const Image& reference, const std::vector<const Metric*>& metrics) {
  FrameScores scores;
  scores.frame = frame;
  scores.not_finite = count_not_finite(image);
  if (scores.not_finite > 0)
    spdlog::warn("{}, frame {}: {} of {} values are NaN or infinite; the frame has no score", method, frame,
                 scores.not_finite, image.pixels.size());
  try {
    for (const Metric* metric : metrics) scores.values.push_back(metric->compute(image, reference));
  } catch (const Error& error) {
    fail("{}, frame {}: {}", method, frame, error.what());
  }
  return scores;
}

/// First pass: the widths of the blur. False when a stop was asked for.
bool sweep_blurs(const FrameSet& frames, const EvaluatorOptions& options, BlurSweep& sweep) {
  Progress progress("choosing the blur", static_cast<int64_t>(frames.count));
  for (size_t i = 0; i < frames.count; ++i) {
    if (stop_requested()) return false;
    const EvaluationFrame frame = frames.load(i);
    try {
      sweep.add(frame.name, mean_radiance(frame.frame), frame.reference, options.threads);
    } catch (const Error& error) {
      fail("frame {}: {}", frame.name, error.what());
    }
    progress.advance();
  }
  return true;
}

/// `seconds` receives what denoising took; for a picture that is read, what its program noted, if it did.
Image picture_of(const Method& method, const EvaluationFrame& frame, SequenceState& state,
                 std::optional<double>& seconds) {
  if (method.read) {
    const auto noted = method.seconds.find(frame.name);
    if (noted != method.seconds.end()) seconds = noted->second;
    PicturePlace place = frame.place;
    place.extent.width = frame.frame.width;
    place.extent.height = frame.frame.height;
    return method.read(frame.name, place);
  }
  state.advance(frame.in_sequence, frame.frame.width, frame.frame.height, frame.frame.info.cut);
  const auto start = std::chrono::steady_clock::now();
  Image denoised = method.denoise(frame.frame, state);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  seconds = elapsed.count();
  return denoised;
}

/// The floor of a reference; none where it lacks one of metrics(). Nobody knows that of the further ones.
std::optional<FrameScores> floor_of(const EvaluationFrame& frame, const std::vector<const Metric*>& metrics) {
  FrameScores scores;
  scores.frame = frame.name;
  for (const Metric* metric : metrics) {
    const auto score = frame.floor.find(metric->name);
    const bool known = score != frame.floor.end();
    if (!known && scores.values.size() < ld::metrics().size()) return std::nullopt;
    scores.values.push_back(known ? score->second : std::numeric_limits<double>::quiet_NaN());
    scores.applies.push_back(known);
  }
  return scores;
}

size_t metric_index(const std::string& name) {
  return static_cast<size_t>(&find_metric(name) - metrics().data());
}

}  // namespace

std::optional<Evaluation> evaluate(const FrameSet& frames, const std::vector<Method>& methods,
                                   const EvaluatorOptions& options) {
  std::vector<std::string> names;
  for (const Method& method : methods) names.push_back(method.name);
  check_method_names(names);
  if (frames.count == 0) fail("there is no frame to evaluate");

  BlurSweep sweep;
  if (!sweep_blurs(frames, options, sweep)) return std::nullopt;
  const double shown_sigma = sweep.best_sigma(metric_index("psnr"));

  Evaluation result;
  result.metrics = options.metrics;
  result.methods.resize(2 + methods.size());
  result.methods[0].name = "noisy";
  result.methods[1] = sweep.scores();
  result.methods[1].sigmas.resize(options.metrics.size(), shown_sigma);
  for (size_t m = 0; m < methods.size(); ++m) {
    result.methods[2 + m].name = methods[m].name;
    result.methods[2 + m].cost = methods[m].cost;
  }
  result.floor = MethodScores{"reference's floor", {}, {}};

  names.insert(names.begin(), {"noisy", "blur"});
  SequenceScorer sequences(names, options.metrics);
  // Only what the sweep has not judged.
  const std::vector<const Metric*> further(
      options.metrics.begin() + static_cast<std::ptrdiff_t>(metrics().size()), options.metrics.end());
  const bool blurs = options.on_pictures || options.sequences || !further.empty();

  // Second pass: everything else, one frame in memory at a time.
  Progress progress("evaluating", static_cast<int64_t>(frames.count));
  std::vector<SequenceState> states(methods.size());
  for (size_t i = 0; i < frames.count; ++i) {
    if (stop_requested()) return std::nullopt;
    const EvaluationFrame frame = frames.load(i);
    const std::optional<FrameScores> floor = floor_of(frame, options.metrics);
    if (floor && result.floor)
      result.floor->frames.push_back(*floor);
    else
      result.floor.reset();
    const auto scored = [&](const std::string& name, const Image& image) {
      return score(name, frame.name, image, frame.reference, options.metrics);
    };
    std::vector<LabelledPicture> pictures;
    pictures.push_back({"noisy", mean_radiance(frame.frame)});
    result.methods[0].frames.push_back(scored("noisy", pictures[0].image));
    pictures.push_back({"blur", blurs ? gaussian_blur(pictures[0].image, shown_sigma) : Image()});
    if (!further.empty()) {
      const FrameScores more = score("blur", frame.name, pictures[1].image, frame.reference, further);
      std::vector<double>& values = result.methods[1].frames[i].values;
      values.insert(values.end(), more.values.begin(), more.values.end());
    }
    for (size_t m = 0; m < methods.size(); ++m) {
      std::optional<double> seconds;
      Image denoised = picture_of(methods[m], frame, states[m], seconds);
      FrameScores scores = scored(methods[m].name, denoised);
      scores.seconds = seconds;
      result.methods[2 + m].frames.push_back(std::move(scores));
      pictures.push_back({methods[m].name, std::move(denoised)});
    }
    if (options.sequences) {
      std::vector<const Image*> images;
      std::vector<const FrameScores*> scores;
      for (size_t m = 0; m < pictures.size(); ++m) {
        images.push_back(&pictures[m].image);
        scores.push_back(&result.methods[m].frames[i]);
      }
      sequences.add(frame, images, scores);
    }
    if (options.on_pictures) {
      pictures.push_back({"reference", frame.reference});
      options.on_pictures(i, frame.name, pictures);
    }
    progress.advance();
  }
  if (options.sequences) {
    SequenceResults found = sequences.finish();
    for (size_t m = 0; m < result.methods.size(); ++m) {
      found.evaluation.methods[m].cost = result.methods[m].cost;
      found.evaluation.methods[m].sigmas.clear();
    }
    result.sequences = std::make_shared<const SequenceResults>(std::move(found));
  }
  return result;
}

}  // namespace ld
