#include <fmt/format.h>

#include "benchmark/network_sweeps.h"
#include "core/text_table.h"

namespace ld {
namespace {

std::string thousands(double multiply_adds) {
  return fmt::format("{:.1f}", multiply_adds / 1e3);
}

}  // namespace

std::string markdown(const std::vector<SampleTime>& times) {
  std::vector<TableRow> table = {{"samples a pixel", "layer network, ms", "to 8 samples"}};
  for (const SampleTime& time : times)
    table.push_back(
        {fmt::format("{}", time.spp), fmt::format("{:.1f}", time.ms), fmt::format("{:.2f}", time.ratio)});
  return markdown_table(table, 0);
}

std::string markdown(const std::vector<NetworkCosts>& costs, const std::vector<int64_t>& spp) {
  std::vector<TableRow> table = {{"thousand multiply-adds a pixel at"}};
  for (const int64_t count : spp) table[0].push_back(fmt::format("{} spp", count));
  for (const NetworkCosts& cost : costs) {
    table.push_back({cost.network});
    for (const double value : cost.per_pixel) table.back().push_back(thousands(value));
  }
  return markdown_table(table, 1);
}

std::string markdown(const std::vector<NetworkStages>& stages) {
  std::vector<TableRow> table = {{"network", "stage", "ms", "thousand multiply-adds a pixel"}};
  for (const NetworkStages& network : stages) {
    double ms = 0, cost = 0;
    for (const StageTime& stage : network.stages) {
      table.push_back(
          {network.network, stage.stage, fmt::format("{:.1f}", stage.ms), thousands(stage.multiply_adds)});
      ms += stage.ms;
      cost += stage.multiply_adds;
    }
    table.push_back({network.network, "total", fmt::format("{:.1f}", ms), thousands(cost)});
  }
  return markdown_table(table, 2);
}

LinePlot figure(const std::vector<SampleTime>& times) {
  LinePlot plot{"Inference by number of samples", "samples a pixel", "ms", true, false, {{"layer", {}}}};
  for (const SampleTime& time : times) plot.lines[0].points.emplace_back(double(time.spp), time.ms);
  return plot;
}

LinePlot figure(const std::vector<NetworkCosts>& costs, const std::vector<int64_t>& spp) {
  LinePlot plot{"Cost by number of samples", "samples a pixel", "multiply-adds a pixel", true, true, {}};
  for (const NetworkCosts& cost : costs) {
    plot.lines.push_back({cost.network, {}});
    for (size_t i = 0; i < spp.size(); ++i)
      plot.lines.back().points.emplace_back(double(spp[i]), cost.per_pixel[i]);
  }
  return plot;
}

BarPlot figure(const std::vector<NetworkStages>& stages) {
  BarPlot plot{"Inference by stage", "ms", {}, {}};
  for (const NetworkStages& network : stages) {
    plot.bars.push_back({network.network, {}});
    for (const StageTime& stage : network.stages) {
      if (plot.bars.size() == 1) plot.parts.push_back(stage.stage);
      plot.bars.back().parts.push_back(stage.ms);
    }
  }
  return plot;
}

nlohmann::ordered_json to_json(const std::vector<SampleTime>& times) {
  auto json = nlohmann::ordered_json::array();
  for (const SampleTime& time : times)
    json.push_back({{"network", "layer"}, {"spp", time.spp}, {"ms", time.ms}, {"ratio_to_8spp", time.ratio}});
  return json;
}

nlohmann::ordered_json to_json(const std::vector<NetworkCosts>& costs, const std::vector<int64_t>& spp) {
  auto json = nlohmann::ordered_json::array();
  for (const NetworkCosts& cost : costs)
    for (size_t i = 0; i < spp.size(); ++i)
      json.push_back(
          {{"network", cost.network}, {"spp", spp[i]}, {"multiply_adds_per_pixel", cost.per_pixel[i]}});
  return json;
}

nlohmann::ordered_json to_json(const std::vector<NetworkStages>& stages) {
  auto json = nlohmann::ordered_json::array();
  for (const NetworkStages& network : stages)
    for (const StageTime& stage : network.stages)
      json.push_back({{"network", network.network},
                      {"stage", stage.stage},
                      {"ms", stage.ms},
                      {"multiply_adds_per_pixel", stage.multiply_adds}});
  return json;
}

}  // namespace ld
