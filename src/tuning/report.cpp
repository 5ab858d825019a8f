#include "tuning/report.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "core/file_io.h"
#include "core/text_table.h"
#include "export/model_card.h"
#include "graph/extent.h"
#include "models/graphs/network_cost.h"
#include "models/graphs/network_graph.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

std::string conditions(const SearchQuestion& question) {
  const PictureExtent& picture = question.picture;
  return fmt::format("{}x{} at {} spp, {} thread{}", picture.width, picture.height, picture.samples,
                     question.threads, question.threads == 1 ? "" : "s");
}

int64_t parameter_count_of(const Point& point) {
  return graph::parameter_count(network_graph(point.candidate.config.network));
}

double multiply_adds_a_pixel(const Point& point, const PictureExtent& picture) {
  return multiply_adds(point.candidate.config.network, picture.samples, picture.height, picture.width)
             .total() /
         double(picture.height * picture.width);
}

std::string sentence_list(const SearchOutcome& outcome) {
  std::string text;
  for (const std::string& sentence : outcome.sentences) text += "- " + sentence + "\n";
  return text;
}

}  // namespace

std::string markdown(const SearchOutcome& outcome, const SearchQuestion& question) {
  std::vector<TableRow> table = {{"", "SMAPE", "ms a frame", "predicted ms", "memory MB", "parameters",
                                  "multiply-adds a pixel", "minutes trained", "unbeaten"}};
  for (size_t i = 0; i < outcome.points.size(); ++i) {
    const Point& point = outcome.points[i];
    table.push_back({point.name + (outcome.chosen == i ? " (chosen)" : ""),
                     fmt::format("{:.5f}", point.error), fmt::format("{:.4g}", point.time.ms),
                     point.eight_bits ? "-" : fmt::format("{:.4g}", point.predicted_ms),
                     fmt::format("{:.0f}", point.time.memory_mb),
                     fmt::format("{:.1f} k", 1e-3 * double(parameter_count_of(point))),
                     fmt::format("{:.1f} k", 1e-3 * multiply_adds_a_pixel(point, question.picture)),
                     fmt::format("{:.2g}", point.minutes), point.unbeaten ? "yes" : ""});
  }
  return markdown_table(table, 1) +
         fmt::format(
             "\nSMAPE: mean over the validation frames of {}; {:.5f} before denoising. Times and memory of "
             "{}, "
             "random samples. Unbeaten: nothing else is at least as good in SMAPE and time and better in "
             "one.\n",
             question.data, question.noisy_error, conditions(question));
}

ScatterPlot figure(const SearchOutcome& outcome, const SearchQuestion& question) {
  ScatterPlot plot;
  plot.title = "SMAPE against cost, " + conditions(question);
  plot.y_label = "SMAPE (lower is better)";
  plot.x_labels = {"ms a frame", "memory, MB"};
  plot.filled_label = "nothing beats it in SMAPE and time";
  plot.hollow_label = "another beats it";
  for (size_t i = 0; i < outcome.points.size(); ++i) {
    const Point& point = outcome.points[i];
    const bool chosen = outcome.chosen == i;
    plot.marks.push_back({(chosen ? "chosen: " : "") + point.name,
                          {point.time.ms, point.time.memory_mb},
                          point.error,
                          point.unbeaten,
                          chosen});
  }
  plot.levels = {{"noisy", question.noisy_error}};
  if (question.requirement.target_smape)
    plot.levels.push_back({"target", *question.requirement.target_smape});
  return plot;
}

nlohmann::ordered_json to_json(const SearchOutcome& outcome, const SearchQuestion& question) {
  nlohmann::ordered_json json = {{"version", LD_VERSION},           {"data", question.data},
                                 {"width", question.picture.width}, {"height", question.picture.height},
                                 {"spp", question.picture.samples}, {"threads", question.threads},
                                 {"minutes", question.minutes},     {"noisy", question.noisy_error}};
  if (question.requirement.budget_ms) json["budget_ms"] = *question.requirement.budget_ms;
  if (question.requirement.target_smape) json["target_smape"] = *question.requirement.target_smape;
  json["decisions"] = outcome.sentences;
  if (outcome.chosen) json["chosen"] = outcome.points[*outcome.chosen].name;
  auto points = nlohmann::ordered_json::array();
  for (const Point& point : outcome.points)
    points.push_back({{"name", point.name},
                      {"trial", point.trial},
                      {"smape", point.error},
                      {"ms", point.time.ms},
                      {"predicted_ms", point.predicted_ms},
                      {"memory_mb", point.time.memory_mb},
                      {"parameters", parameter_count_of(point)},
                      {"multiply_adds_per_pixel", multiply_adds_a_pixel(point, question.picture)},
                      {"minutes", point.minutes},
                      {"dtype", point.eight_bits ? "i8" : "f32"},
                      {"unbeaten", point.unbeaten},
                      {"smape_of_frames", point.errors}});
  json["points"] = points;
  return json;
}

void write_model(const std::filesystem::path& out, const std::filesystem::path& model,
                 const SearchOutcome& outcome, const SearchQuestion& question) {
  const Point& chosen = outcome.points[*outcome.chosen];
  const SafetensorsFile file(resolve_model(model));
  Metadata metadata = file.metadata();
  metadata["export"] = nlohmann::ordered_json({{"program", "ld_tune " LD_VERSION},
                                               {"dtype", chosen.eight_bits ? "i8" : "f32"},
                                               {"validation",
                                                {{"data", question.data},
                                                 {"frames", chosen.errors.size()},
                                                 {"smape", chosen.error},
                                                 {"noisy", question.noisy_error}}},
                                               {"ms_a_frame", chosen.time.ms},
                                               {"of", conditions(question)}})
                           .dump();
  metadata["tuning"] = nlohmann::ordered_json({{"decisions", outcome.sentences}}).dump();
  write_safetensors(out, file.tensors(), metadata);
  std::filesystem::path card = out;
  card.replace_extension(".md");
  write_file_atomically(card, model_card(out.filename().string(), metadata) + "\n## How it was found\n\n" +
                                  sentence_list(outcome) + "\n" + markdown(outcome, question));
}

}  // namespace ld
