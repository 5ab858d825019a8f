#include "benchmark/tradeoff.h"

#include <algorithm>
#include <functional>
#include <memory>

#include "benchmark/measure.h"
#include "benchmark/peak_memory.h"
#include "core/error.h"
#include "core/file_io.h"
#include "core/json_text.h"
#include "core/log.h"
#include "core/progress.h"
#include "core/signals.h"
#include "evaluation/data_set.h"
#include "evaluation/evaluator.h"
#include "evaluation/image_folder.h"
#include "inference/filter_method.h"
#include "inference/model_method.h"
#include "metrics/metric.h"

namespace ld {
namespace {

/// The memory that another program noted beside its pictures; their times reach the scores by themselves.
double peak_of(const std::filesystem::path& folder, int threads) {
  const std::filesystem::path path = folder / "cost.json";
  const auto json = parse_json(read_file(path, 1 << 24), path.string());
  try {
    const int64_t found = whole_number(json, "threads", path.string());
    if (found != threads)
      fail("{}: measured on {} threads, this run uses {}; run both on the same number (--threads)",
           path.string(), found, threads);
    return json.at("peak_mb");
  } catch (const nlohmann::json::exception& error) {
    fail("{}: expected {{\"threads\", \"peak_mb\", \"seconds\": {{FRAME: s}}}}: {}", path.string(),
         error.what());
  }
}

/// What is timed: denoises a frame; `afresh` does so with all that it has to load and keep.
struct TimedMethod {
  std::function<void(const Frame&)> denoise, afresh;
};

TimedMethod timed(const LoadedModel& model) {
  return {[model](const Frame& frame) { denoise(model, frame); },
          [model](const Frame& frame) { denoise(load_model(model.argument, model.threads), frame); }};
}

/// With the history of the calls before, as in a sequence.
TimedMethod timed(const FilterArgument& argument, int threads) {
  const auto filter = std::make_shared<FrameFilter>(argument);
  const auto state = std::make_shared<SequenceState>();
  return {[=](const Frame& frame) { filter->denoise(frame, *state, threads); },
          [=](const Frame& frame) {
            SequenceState own;
            FrameFilter(argument).denoise(frame, own, threads);
          }};
}

/// Times all on each frame in turns; false when a stop was asked for.
bool time_methods(const FrameSet& frames, const std::vector<TimedMethod>& methods, int repeats,
                  Tradeoff& tradeoff) {
  Progress progress("timing", int64_t(frames.count));
  for (size_t i = 0; i < frames.count; ++i) {
    const EvaluationFrame frame = frames.load(i);
    std::vector<std::vector<double>> times(methods.size());
    for (int repeat = 0; repeat <= repeats; ++repeat)
      for (size_t m = 0; m < methods.size(); ++m) {
        if (stop_requested()) return false;
        const double ms = time_ms([&] { methods[m].denoise(frame.frame); });
        if (repeat > 0) times[m].push_back(ms);  // the first warms up
      }
    for (size_t m = 0; m < methods.size(); ++m) {
      TradeoffPoint& point = tradeoff.points[m];
      point.ms += median(times[m]) / double(frames.count);
      point.peak_mb = std::max(point.peak_mb, peak_memory_mb([&] { methods[m].afresh(frame.frame); }));
    }
    progress.advance();
  }
  return true;
}

std::vector<double> means(const MethodScores& method) {
  std::vector<double> scores;
  for (size_t metric = 0; metric < metrics().size(); ++metric) scores.push_back(method.mean(metric));
  return scores;
}

}  // namespace

std::optional<Tradeoff> measure_tradeoff(const TradeoffOptions& options) {
  find_metric(options.metric);
  if (options.models.empty() && options.filters.empty() && options.images.empty())
    fail_usage("ld_bench tradeoff: nothing to measure; give --model NAME=FILE, once for each model");
  std::vector<std::string> features = {"radiance"};
  const std::vector<LoadedModel> models =
      load_models(parse_model_arguments(options.models), options.threads, features);
  const FrameSet frames =
      open_frame_set(options.data, options.split, features, options.frames_limit, options.samples);

  Tradeoff tradeoff;
  std::vector<Method> methods;
  std::vector<TimedMethod> timed_methods;
  const Frame first = frames.load(0).frame;
  for (const LoadedModel& model : models) {
    methods.push_back(method_of(model, cost_of(model, first)));
    timed_methods.push_back(timed(model));
  }
  for (const FilterArgument& filter : options.filters) {
    methods.push_back(filter_method(filter, options.threads));
    timed_methods.push_back(timed(filter, options.threads));
  }
  tradeoff.points.resize(methods.size());
  for (const ModelArgument& folder : parse_named_arguments("--images", "oidn=out/oidn", options.images)) {
    methods.push_back(image_folder_method(folder.name, folder.file, frames.names));
    tradeoff.points.emplace_back();
    tradeoff.points.back().other_program = true;
    tradeoff.points.back().peak_mb = peak_of(folder.file, options.threads);
  }

  EvaluatorOptions evaluator;
  evaluator.threads = options.threads;
  const std::optional<Evaluation> scored = evaluate(frames, methods, evaluator);
  if (!scored || !time_methods(frames, timed_methods, options.repeats, tradeoff)) return std::nullopt;
  tradeoff.data = options.data.string();
  tradeoff.split = options.split;
  tradeoff.metric = options.metric;
  tradeoff.frames = frames.count;
  tradeoff.width = first.width;
  tradeoff.height = first.height;
  tradeoff.spp = first.spp;
  tradeoff.threads = options.threads;
  tradeoff.noisy = means(scored->method("noisy"));
  tradeoff.blur = means(scored->method("blur"));
  for (size_t i = 0; i < tradeoff.points.size(); ++i) {
    TradeoffPoint& point = tradeoff.points[i];
    const MethodScores& scores = scored->method(methods[i].name);
    point.name = scores.name;
    point.scores = means(scores);
    point.parameters = scores.cost.parameters;
    point.multiply_adds = scores.cost.multiply_adds;
    if (!point.other_program) continue;
    if (!scores.mean_seconds())
      fail("--images {}: its cost.json has no seconds for these frames", point.name);
    point.ms = 1e3 * *scores.mean_seconds();
  }
  mark_unbeaten(tradeoff.points, size_t(&find_metric(options.metric) - metrics().data()));
  return tradeoff;
}

}  // namespace ld
