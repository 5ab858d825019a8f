#include "evaluation/tables.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "core/text_table.h"
#include "evaluation/blur_sweep.h"
#include "metrics/metric.h"
#include "metrics/relmse.h"
#include "metrics/smape.h"

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

Row headings(const Row& first) {
  Row row = first;
  for (const Metric& metric : metrics()) row.push_back(metric.title);
  row.push_back("s/frame");
  return row;
}

/// "2.83 px for relMSE, ..."; says where the sweep ended, since the best may lie beyond.
std::string describe_blur(const std::vector<double>& sigmas) {
  Row parts;
  for (size_t m = 0; m < sigmas.size(); ++m) {
    const bool at_end = sigmas[m] <= blur_sigmas().front() || sigmas[m] >= blur_sigmas().back();
    parts.push_back(fmt::format("{:.3g} px for {}{}", sigmas[m], metrics()[m].title,
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

std::vector<double> means(const MethodScores& method) {
  std::vector<double> values;
  for (size_t m = 0; m < metrics().size(); ++m) values.push_back(method.mean(m));
  return values;
}

nlohmann::ordered_json json_values(const std::vector<double>& values) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (size_t m = 0; m < values.size(); ++m) {
    auto& entry = json[metrics()[m].name];
    if (std::isfinite(values[m])) entry = values[m];  // else it stays null
  }
  return json;
}

}  // namespace

std::string markdown_means(const Evaluation& evaluation) {
  std::vector<Row> rows = {headings({"method"})};
  for (const MethodScores& method : evaluation.methods) {
    Row row = {method.name};
    for (size_t m = 0; m < metrics().size(); ++m) row.push_back(number(method.mean(m), metrics()[m].digits));
    row.push_back(seconds(method.mean_seconds()));
    rows.push_back(row);
  }
  std::string text = markdown_table(rows, 1) + "\n";
  for (const Metric& metric : metrics())
    text += fmt::format("- {}: {} is better; {}\n", metric.title, metric.lower_is_better ? "lower" : "higher",
                        metric.domain);
  for (const MethodScores& method : evaluation.methods) {
    if (!method.sigmas.empty())
      text += fmt::format("- {}: Gaussian, its width chosen for each metric: {}\n", method.name,
                          describe_blur(method.sigmas));
    if (method.not_finite() > 0)
      text +=
          fmt::format("- {}: {} values are NaN or infinite; those frames, and so the mean, have no score\n",
                      method.name, method.not_finite());
  }
  return text;
}

std::string markdown_frames(const Evaluation& evaluation) {
  std::vector<Row> rows = {headings({"frame", "method"})};
  const size_t frame_count = evaluation.methods.empty() ? 0 : evaluation.methods.front().frames.size();
  for (size_t f = 0; f < frame_count; ++f)
    for (const MethodScores& method : evaluation.methods) {
      const FrameScores& scores = method.frames[f];
      Row row = {scores.frame, method.name};
      for (size_t m = 0; m < metrics().size(); ++m)
        row.push_back(number(scores.values[m], metrics()[m].digits));
      row.push_back(seconds(scores.seconds));
      rows.push_back(row);
    }
  return markdown_table(rows, 2);
}

std::string to_csv(const Evaluation& evaluation) {
  std::string text = "method,frame";
  for (const Metric& metric : metrics()) text += "," + metric.name;
  text += ",seconds,not_finite\n";
  for (const MethodScores& method : evaluation.methods) {
    for (const FrameScores& frame : method.frames)
      text += csv_row(method.name, frame.frame, frame.values, frame.seconds, frame.not_finite);
    text += csv_row(method.name, "mean", means(method), method.mean_seconds(), method.not_finite());
  }
  return text;
}

nlohmann::ordered_json to_json(const Evaluation& evaluation) {
  nlohmann::ordered_json json;
  json["data"] = evaluation.data;
  json["split"] = evaluation.split;
  json["frame_count"] = evaluation.methods.empty() ? 0 : evaluation.methods.front().frames.size();
  json["relmse_epsilon"] = kRelmseEpsilon;
  json["smape_epsilon"] = kSmapeEpsilon;
  for (const Metric& metric : metrics())
    json["metrics"][metric.name] = {{"better", metric.lower_is_better ? "lower" : "higher"},
                                    {"domain", metric.domain}};

  json["methods"] = nlohmann::ordered_json::object();
  for (const MethodScores& method : evaluation.methods) {
    nlohmann::ordered_json& entry = json["methods"][method.name];
    entry["mean"] = json_values(means(method));
    if (const auto time = method.mean_seconds()) entry["seconds"] = *time;
    entry["not_finite"] = method.not_finite();
    if (!method.sigmas.empty()) entry["sigma"] = json_values(method.sigmas);
    entry["frames"] = nlohmann::ordered_json::array();
    for (const FrameScores& frame : method.frames) {
      nlohmann::ordered_json row = {{"name", frame.frame}};
      row.update(json_values(frame.values));
      if (frame.seconds) row["seconds"] = *frame.seconds;
      row["not_finite"] = frame.not_finite;
      entry["frames"].push_back(row);
    }
  }
  return json;
}

}  // namespace ld
