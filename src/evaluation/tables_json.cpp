#include <cmath>

#include "evaluation/comparison.h"
#include "evaluation/sequence_evaluation.h"
#include "evaluation/tables.h"
#include "metrics/metric.h"
#include "metrics/relmse.h"
#include "metrics/smape.h"

namespace ld {
namespace {

using Json = nlohmann::ordered_json;

/// Null for what JSON has no number for.
Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json json_interval(const std::optional<Interval>& interval) {
  return interval ? Json{interval->low, interval->high} : Json();
}

Json json_values(const Evaluation& evaluation, const std::vector<double>& values) {
  Json json = Json::object();
  for (size_t m = 0; m < values.size(); ++m) json[evaluation.metrics[m]->name] = number_or_null(values[m]);
  return json;
}

Json json_frame(const Evaluation& evaluation, const FrameScores& frame) {
  Json row = {{"name", frame.frame}};
  row.update(json_values(evaluation, frame.values));
  if (frame.seconds) row["seconds"] = *frame.seconds;
  row["not_finite"] = frame.not_finite;
  return row;
}

void add_means(Json& entry, const Evaluation& evaluation, const MethodScores& method) {
  for (size_t m = 0; m < evaluation.metrics.size(); ++m) {
    entry["mean"][evaluation.metrics[m]->name] = number_or_null(method.mean(m));
    entry["interval"][evaluation.metrics[m]->name] = json_interval(mean_interval(method.values(m)));
  }
}

Json json_floor(const Evaluation& evaluation, const MethodScores& floor) {
  Json entry = {{"name", floor.name}, {"text", floor_text()}};
  add_means(entry, evaluation, floor);
  entry["frames"] = Json::array();
  for (const FrameScores& frame : floor.frames) {
    Json row = {{"name", frame.frame}};
    row.update(json_values(evaluation, frame.values));
    entry["frames"].push_back(row);
  }
  return entry;
}

Json json_method(const Evaluation& evaluation, const MethodScores& method) {
  Json entry;
  add_means(entry, evaluation, method);
  if (const auto time = method.mean_seconds()) entry["seconds"] = *time;
  if (method.cost.parameters) entry["parameters"] = *method.cost.parameters;
  if (method.cost.multiply_adds) entry["multiply_adds_per_pixel"] = *method.cost.multiply_adds;
  entry["not_finite"] = method.not_finite();
  if (!method.sigmas.empty()) entry["sigma"] = json_values(evaluation, method.sigmas);
  entry["frames"] = Json::array();
  for (const FrameScores& frame : method.frames) entry["frames"].push_back(json_frame(evaluation, frame));
  return entry;
}

}  // namespace

Json comparison_json(const Evaluation& evaluation, const MethodScores& baseline) {
  const Comparison comparison = compare_with(evaluation, baseline);
  Json json = {{"baseline", comparison.baseline},
               {"frame_count", comparison.frame_count},
               {"too_few_frames", comparison.too_few_frames()},
               {"methods", Json::object()}};
  for (const PairedMethod& method : comparison.methods)
    for (size_t m = 0; m < evaluation.metrics.size(); ++m) {
      const PairedMetric& paired = method.metrics[m];
      json["methods"][method.name][evaluation.metrics[m]->name] = {
          {"mean_difference", number_or_null(paired.mean_difference)},
          {"interval", json_interval(paired.interval)},
          {"better", paired.better},
          {"worse", paired.worse},
          {"equal", paired.equal},
          {"p", paired.p ? Json(*paired.p) : Json()}};
    }
  return json;
}

Json to_json(const Evaluation& evaluation) {
  Json json;
  json["data"] = evaluation.data;
  json["split"] = evaluation.split;
  if (evaluation.samples > 0) json["samples"] = evaluation.samples;
  json["unit"] = evaluation.unit();
  json["frame_count"] = evaluation.methods.empty() ? 0 : evaluation.methods.front().frames.size();
  json["relmse_epsilon"] = kRelmseEpsilon;
  json["smape_epsilon"] = kSmapeEpsilon;
  json["confidence"] = kConfidence;
  for (const Metric* metric : evaluation.metrics)
    json["metrics"][metric->name] = {{"title", metric->title},
                                     {"better", better_word(metric->best)},
                                     {"domain", metric->domain},
                                     {"formula", metric->formula},
                                     {"digits", metric->digits}};
  json["methods"] = Json::object();
  for (const MethodScores& method : evaluation.methods)
    json["methods"][method.name] = json_method(evaluation, method);
  if (evaluation.floor) json["floor"] = json_floor(evaluation, *evaluation.floor);
  if (!evaluation.methods.empty())
    json["comparison"] = comparison_json(evaluation, evaluation.baseline_method());
  if (evaluation.sequences) json["sequences"] = to_json(sequence_scores(evaluation));
  return json;
}

}  // namespace ld
