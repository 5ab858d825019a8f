#include <fmt/format.h>

#include <cmath>

#include "benchmark/tradeoff.h"
#include "core/text_table.h"
#include "metrics/metric.h"

namespace ld {
namespace {

/// Lower is better in all of them.
std::vector<double> costs(const TradeoffPoint& point, size_t metric) {
  const double score = point.scores[metric];
  return {metrics()[metric].best == Best::lowest ? score : -score, point.ms, point.peak_mb};
}

bool beats(const std::vector<double>& a, const std::vector<double>& b) {
  bool better = false;
  for (size_t i = 0; i < a.size(); ++i) {
    if (!(a[i] <= b[i])) return false;
    better = better || a[i] < b[i];
  }
  return better;
}

nlohmann::ordered_json scores_json(const std::vector<double>& scores) {
  nlohmann::ordered_json json;
  for (size_t m = 0; m < scores.size(); ++m)
    json[metrics()[m].name] = std::isfinite(scores[m]) ? nlohmann::ordered_json(scores[m]) : nullptr;
  return json;
}

TableRow score_cells(const std::string& name, const std::vector<double>& scores) {
  TableRow row = {name};
  for (size_t m = 0; m < scores.size(); ++m)
    row.push_back(fmt::format("{:.{}f}", scores[m], metrics()[m].digits));
  return row;
}

}  // namespace

void mark_unbeaten(std::vector<TradeoffPoint>& points, size_t metric) {
  for (TradeoffPoint& point : points) {
    point.unbeaten = !point.other_program && std::isfinite(point.scores[metric]);
    for (const TradeoffPoint& other : points)
      if (!other.other_program && beats(costs(other, metric), costs(point, metric))) point.unbeaten = false;
  }
}

std::string markdown(const Tradeoff& tradeoff) {
  std::vector<TableRow> table = {{""}};
  for (const Metric& metric : metrics()) table[0].push_back(metric.title);
  for (const char* heading : {"ms a frame", "peak MB", "parameters", "multiply-adds a pixel", "unbeaten"})
    table[0].emplace_back(heading);
  for (const auto& [name, scores] :
       {std::pair("noisy", tradeoff.noisy), std::pair("best blur", tradeoff.blur)}) {
    TableRow row = score_cells(name, scores);
    row.resize(table[0].size(), "-");
    table.push_back(row);
  }
  for (const TradeoffPoint& point : tradeoff.points) {
    TableRow row = score_cells(point.name, point.scores);
    row.push_back(fmt::format("{:.1f}", point.ms));
    row.push_back(fmt::format("{:.0f}", point.peak_mb));
    row.push_back(point.parameters ? fmt::format("{:.0f} k", double(*point.parameters) / 1e3) : "-");
    row.push_back(point.multiply_adds ? fmt::format("{:.1f} k", *point.multiply_adds / 1e3) : "-");
    row.push_back(point.unbeaten ? "yes" : "");
    table.push_back(row);
  }
  return markdown_table(table, 1) +
         fmt::format(
             "\nMeans over {} frames of {}x{} at {} spp ({}, {}); {} threads. Unbeaten: no other model is at "
             "least as good in {}, time and memory and better in one; other programs are the point to "
             "beat. Times begin with the samples in memory: ours count the encoding, those of other programs "
             "are what their cost.json says. Ours take turns; scripts/speed.sh takes turns with Open Image "
             "Denoise, too.\n",
             tradeoff.frames, tradeoff.width, tradeoff.height, tradeoff.spp, tradeoff.data, tradeoff.split,
             tradeoff.threads, find_metric(tradeoff.metric).title);
}

ScatterPlot figure(const Tradeoff& tradeoff) {
  const Metric& metric = find_metric(tradeoff.metric);
  const auto index = size_t(&metric - metrics().data());
  ScatterPlot plot;
  plot.title = fmt::format("{} against time and memory, {} frames of {}x{}, {} spp", metric.title,
                           tradeoff.frames, tradeoff.width, tradeoff.height, tradeoff.spp);
  plot.y_label = fmt::format("{} ({} is better)", metric.title, better_word(metric.best));
  plot.x_labels = {fmt::format("ms a frame, {} threads", tradeoff.threads), "peak memory, MB"};
  plot.filled_label = "no other model beats it";
  plot.hollow_label = "another model beats it in all";
  for (const TradeoffPoint& point : tradeoff.points)
    plot.marks.push_back({point.name,
                          {point.ms, std::max(point.peak_mb, 0.1)},
                          point.scores[index],
                          point.unbeaten || point.other_program,
                          point.other_program});
  plot.levels = {{"best blur", tradeoff.blur[index]}, {"noisy", tradeoff.noisy[index]}};
  return plot;
}

nlohmann::ordered_json to_json(const Tradeoff& tradeoff) {
  nlohmann::ordered_json json = {{"version", LD_VERSION},
                                 {"data", tradeoff.data},
                                 {"split", tradeoff.split},
                                 {"metric", tradeoff.metric},
                                 {"frames", tradeoff.frames},
                                 {"width", tradeoff.width},
                                 {"height", tradeoff.height},
                                 {"spp", tradeoff.spp},
                                 {"threads", tradeoff.threads},
                                 {"noisy", scores_json(tradeoff.noisy)},
                                 {"blur", scores_json(tradeoff.blur)}};
  auto points = nlohmann::ordered_json::array();
  for (const TradeoffPoint& point : tradeoff.points) {
    nlohmann::ordered_json entry = {{"name", point.name},
                                    {"scores", scores_json(point.scores)},
                                    {"ms", point.ms},
                                    {"peak_mb", point.peak_mb},
                                    {"unbeaten", point.unbeaten},
                                    {"other_program", point.other_program}};
    if (point.parameters) entry["parameters"] = *point.parameters;
    if (point.multiply_adds) entry["multiply_adds_per_pixel"] = *point.multiply_adds;
    points.push_back(entry);
  }
  json["points"] = points;
  return json;
}

}  // namespace ld
