#include "evaluation/tables.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "core/text_table.h"
#include "evaluation/blur_sweep.h"
#include "evaluation/comparison.h"
#include "metrics/metric.h"
#include "metrics/sequence_meter.h"

namespace ld {
namespace {

using Row = TableRow;

/// Fixed decimals, but what would fill the column with digits or vanish in zeros takes an exponent.
std::string number(double value, int digits) {
  if (!std::isfinite(value)) return fmt::format("{}", value);
  const bool fixed = value == 0 || (std::abs(value) < 1e5 && std::abs(value) >= std::pow(10, 1 - digits));
  return fixed ? fmt::format("{:.{}f}", value, digits) : fmt::format("{:.3e}", value);
}

std::string seconds(const std::optional<double>& value) {
  return value ? fmt::format("{:.3f}", *value) : "-";
}

Row headings(const Evaluation& evaluation, const Row& first) {
  Row row = first;
  for (const Metric* metric : evaluation.metrics) row.push_back(metric->title);
  row.push_back("s/frame");
  return row;
}

/// "2.83 px for relMSE, ..."; says where the sweep ended, since the best may lie beyond.
std::string describe_blur(const Evaluation& evaluation, const std::vector<double>& sigmas) {
  Row parts;
  for (size_t m = 0; m < sigmas.size(); ++m) {
    const bool at_end = sigmas[m] <= blur_sigmas().front() || sigmas[m] >= blur_sigmas().back();
    parts.push_back(fmt::format("{:.3g} px for {}{}", sigmas[m], evaluation.metrics[m]->title,
                                at_end ? " (end of the sweep)" : ""));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + "\"";
}

std::string csv_row(const std::string& method, const std::string& frame, const std::vector<double>& values,
                    const std::optional<double>& time, int64_t not_finite) {
  std::string row = quoted(method) + "," + quoted(frame);
  for (const double value : values) row += std::isnan(value) ? ",nan" : fmt::format(",{}", value);
  return row + fmt::format(",{},{}\n", time ? fmt::format("{}", *time) : "", not_finite);
}

std::vector<double> means(const Evaluation& evaluation, const MethodScores& method) {
  std::vector<double> values;
  for (size_t m = 0; m < evaluation.metrics.size(); ++m) values.push_back(method.mean(m));
  return values;
}

/// "-" where the metric applies to no frame.
std::string mean_cell(const Evaluation& evaluation, const MethodScores& method, size_t metric) {
  return method.values(metric).empty() ? "-"
                                       : number(method.mean(metric), evaluation.metrics[metric]->digits);
}

/// The methods and, below them, the floor.
std::vector<const MethodScores*> rows_of(const Evaluation& evaluation) {
  std::vector<const MethodScores*> methods;
  for (const MethodScores& method : evaluation.methods) methods.push_back(&method);
  if (evaluation.floor) methods.push_back(&*evaluation.floor);
  return methods;
}

/// One end of the intervals of all metrics; empty cells where there is none.
std::string interval_row(const Evaluation& evaluation, const MethodScores& method, const std::string& name,
                         double Interval::*end) {
  std::string row = quoted(method.name) + "," + name;
  for (size_t m = 0; m < evaluation.metrics.size(); ++m) {
    const auto interval = mean_interval(method.values(m));
    row += interval ? fmt::format(",{}", (*interval).*end) : ",";
  }
  return row + ",,0\n";
}

std::string range(const std::optional<Interval>& interval, int digits) {
  return interval ? number(interval->low, digits) + " .. " + number(interval->high, digits) : "-";
}

std::string probability(const std::optional<double>& p) {
  return p ? fmt::format(*p < 1e-4 ? "{:.1e}" : "{:.4f}", *p) : "-";
}

}  // namespace

std::string markdown_means(const Evaluation& evaluation) {
  std::vector<Row> rows = {headings(evaluation, {"method"})};
  for (const MethodScores* method : rows_of(evaluation)) {
    Row row = {method->name};
    for (size_t m = 0; m < evaluation.metrics.size(); ++m) row.push_back(mean_cell(evaluation, *method, m));
    row.push_back(seconds(method->mean_seconds()));
    rows.push_back(row);
  }
  std::string text = markdown_table(rows, 1) + "\n";
  for (const Metric* metric : evaluation.metrics)
    if (!evaluation.of_sequences || metric->compute == nullptr)  // those of pictures stand above
      text += fmt::format("- {}: {} is better; {}; on {}\n", metric->title, better_word(metric->best),
                          metric->formula, metric->domain);
  for (const MethodScores& method : evaluation.methods) {
    if (!method.sigmas.empty())
      text += fmt::format("- {}: Gaussian, its width chosen for each metric: {}\n", method.name,
                          describe_blur(evaluation, method.sigmas));
    if (method.not_finite() > 0)
      text +=
          fmt::format("- {}: {} values are NaN or infinite; those frames, and so the mean, have no score\n",
                      method.name, method.not_finite());
  }
  if (evaluation.floor) text += fmt::format("- {}: {}\n", evaluation.floor->name, floor_text());
  return text;
}

std::string markdown_intervals(const Evaluation& evaluation) {
  std::vector<Row> rows = {{"method"}};
  for (const Metric* metric : evaluation.metrics) rows[0].push_back(metric->title);
  for (const MethodScores* method : rows_of(evaluation)) {
    Row row = {method->name};
    for (size_t m = 0; m < evaluation.metrics.size(); ++m)
      row.push_back(range(mean_interval(method->values(m)), evaluation.metrics[m]->digits));
    rows.push_back(row);
  }
  const size_t frames = evaluation.methods.empty() ? 0 : evaluation.methods.front().frames.size();
  return fmt::format("{:g} % confidence intervals of these means over {} {}s (Student's t):\n\n",
                     100 * kConfidence, frames, evaluation.unit()) +
         markdown_table(rows, 1);
}

std::string markdown_comparison(const Evaluation& evaluation) {
  const Comparison comparison = compare_with(evaluation, evaluation.baseline_method());
  std::vector<Row> rows = {{"metric", "method", "difference",
                            fmt::format("{:g} % interval", 100 * kConfidence), "better", "worse", "p"}};
  for (size_t m = 0; m < evaluation.metrics.size(); ++m)
    for (const PairedMethod& method : comparison.methods) {
      const PairedMetric& paired = method.metrics[m];
      const int digits = evaluation.metrics[m]->digits;
      const bool compared = paired.better + paired.worse + paired.equal > 0;
      rows.push_back({evaluation.metrics[m]->title, method.name,
                      compared ? number(paired.mean_difference, digits) : "-", range(paired.interval, digits),
                      std::to_string(paired.better), std::to_string(paired.worse), probability(paired.p)});
    }
  std::string text = fmt::format(
      "In pairs with {0}: method - {0}, mean over {1} {2}s; {2}s that are better and worse; p of Wilcoxon's "
      "signed-rank test, two-sided, not corrected for the number of rows\n\n{3}",
      comparison.baseline, comparison.frame_count, evaluation.unit(), markdown_table(rows, 2));
  if (comparison.too_few_frames())
    text += fmt::format(
        "\n- {} {}s are too few: the signed-rank test cannot come below {:g} with fewer than {}\n",
        comparison.frame_count, evaluation.unit(), 1 - kConfidence, kFewestFrames);
  if (evaluation.floor) {
    Row floors;
    for (size_t m = 0; m < evaluation.metrics.size(); ++m)
      floors.push_back(evaluation.metrics[m]->title + " " + mean_cell(evaluation, *evaluation.floor, m));
    text += fmt::format("\n- {}: {}\n", evaluation.floor->name, fmt::join(floors, ", "));
  }
  return text;
}

std::string floor_text() {
  return "what the references' own noise scores, estimated from two independent halves of their samples; no "
         "method can be told to be better than this";
}

std::string formulas_text() {
  std::string text = "d: denoised, r: reference, linear radiance\n";
  for (const std::vector<Metric>* list : {&metrics(), &further_metrics(), &sequence_measures()})
    for (const Metric& metric : *list)
      text += fmt::format("{} = {} ({})\n", metric.title, metric.formula, metric.domain);
  return text;
}

std::string markdown_frames(const Evaluation& evaluation) {
  std::vector<Row> rows = {headings(evaluation, {evaluation.unit(), "method"})};
  const size_t frame_count = evaluation.methods.empty() ? 0 : evaluation.methods.front().frames.size();
  for (size_t f = 0; f < frame_count; ++f)
    for (const MethodScores* method : rows_of(evaluation)) {
      const FrameScores& scores = method->frames[f];
      Row row = {scores.frame, method->name};
      for (size_t m = 0; m < evaluation.metrics.size(); ++m)
        row.push_back(scores.has(m) ? number(scores.values[m], evaluation.metrics[m]->digits) : "-");
      row.push_back(seconds(scores.seconds));
      rows.push_back(row);
    }
  return markdown_table(rows, 2);
}

std::string to_csv(const Evaluation& evaluation) {
  std::string text = "method,frame";
  for (const Metric* metric : evaluation.metrics) text += "," + metric->name;
  text += ",seconds,not_finite\n";
  for (const MethodScores& method : evaluation.methods) {
    for (const FrameScores& frame : method.frames)
      text += csv_row(method.name, frame.frame, frame.values, frame.seconds, frame.not_finite);
    text +=
        csv_row(method.name, "mean", means(evaluation, method), method.mean_seconds(), method.not_finite());
    text += interval_row(evaluation, method, "ci95_low", &Interval::low);
    text += interval_row(evaluation, method, "ci95_high", &Interval::high);
  }
  return text;
}

std::string comparison_csv(const Evaluation& evaluation) {
  const Comparison comparison = compare_with(evaluation, evaluation.baseline_method());
  const auto cell = [](bool exists, double value) { return exists ? fmt::format("{}", value) : ""; };
  std::string text =
      "baseline,method,metric,frames,mean_difference,ci95_low,ci95_high,better,worse,equal,p\n";
  for (const PairedMethod& method : comparison.methods)
    for (size_t m = 0; m < evaluation.metrics.size(); ++m) {
      const PairedMetric& paired = method.metrics[m];
      const Interval interval = paired.interval.value_or(Interval{});
      text += fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", quoted(comparison.baseline),
                          quoted(method.name), evaluation.metrics[m]->name, comparison.frame_count,
                          cell(std::isfinite(paired.mean_difference), paired.mean_difference),
                          cell(paired.interval.has_value(), interval.low),
                          cell(paired.interval.has_value(), interval.high), paired.better, paired.worse,
                          paired.equal, cell(paired.p.has_value(), paired.p.value_or(0)));
    }
  return text;
}

}  // namespace ld
