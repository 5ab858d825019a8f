#include "tuning/tune.h"

#include <algorithm>
#include <iostream>

#include "core/checksum.h"
#include "core/error.h"
#include "core/file_io.h"
#include "core/json_text.h"
#include "core/log.h"
#include "core/signals.h"
#include "training/run/config_file.h"
#include "tuning/workshop.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

/// The folder of this program, where ld_train lies, too.
fs::path program_folder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

/// A configuration that comes with the programs: installed, or where they were built.
fs::path shipped_config(const std::string& name) {
  const fs::path installed = program_folder().parent_path() / "share/layer_denoiser/configs" / name;
  return fs::is_regular_file(installed) ? installed : fs::path(LD_CONFIGS) / name;
}

TrainConfig read_shared_config(const TuneOptions& options) {
  const fs::path file =
      options.config.empty() ? shipped_config("samples_fast.yaml") : fs::path(options.config);
  return read_train_config(file, options.overrides);
}

TrainConfig with_data(TrainConfig config, const TuneOptions& options, const DataSurvey& survey) {
  if (options.seed) config.seed = *options.seed;
  config.init.clear();
  config.data.path = options.data.string();
  config.data.paths.clear();
  config.data.samples = {survey.samples, survey.samples};
  config.data.validation_samples = survey.samples;
  config.run.images = 0;
  return config;
}

/// Throws UsageError where the folder holds the answer to another question.
void claim(const fs::path& folder, const TuneOptions& options, const TrainConfig& shared,
           const PictureExtent& picture) {
  nlohmann::ordered_json question = {{"program", "ld_tune " LD_VERSION},
                                     {"manifest", file_checksum(options.data / "manifest.json")},
                                     {"at", fmt::format("{}x{}", picture.width, picture.height)},
                                     {"samples", picture.samples},
                                     {"minutes", options.minutes},
                                     {"threads", options.threads},
                                     {"config", config_to_yaml(shared)}};
  question["budget_ms"] =
      options.requirement.budget_ms ? nlohmann::ordered_json(*options.requirement.budget_ms) : nullptr;
  question["target_smape"] =
      options.requirement.target_smape ? nlohmann::ordered_json(*options.requirement.target_smape) : nullptr;
  const fs::path path = folder / "search.json";
  if (!fs::exists(path)) {
    write_file_atomically(path, question.dump(2) + "\n");
    return;
  }
  const nlohmann::json before = parse_json(read_file(path), path.string());
  for (const auto& [key, value] : question.items())
    if (!before.contains(key) || before.at(key) != nlohmann::json(value))
      fail_usage(
          "{} holds another search: {} was {}, is {}; choose another --out or --work, or remove that folder",
          folder.string(), key, key == "config" ? "another" : before.value(key, nlohmann::json()).dump(),
          key == "config" ? "this one" : value.dump());
}

}  // namespace

fs::path TuneOptions::folder() const {
  return work.empty() ? fs::path(out.string() + ".tune") : work;
}

std::pair<int64_t, int64_t> parse_size(const std::string& text) {
  int64_t width = 0, height = 0;
  int end = 0;
  if (std::sscanf(text.c_str(), "%5ldx%5ld%n", &width, &height, &end) != 2 || size_t(end) != text.size() ||
      width < 1 || height < 1 || width > 16384 || height > 16384)
    fail_usage("--at {}: expected WIDTHxHEIGHT in pixels, 1 to 16384 each, as 1920x1080", text);
  return {width, height};
}

std::optional<nlohmann::ordered_json> tune(const TuneOptions& options) {
  const TrainConfig config = read_shared_config(options);  // what is wrong in it is told first
  const DataSurvey survey = survey_data(options.data, options.samples, options.threads);
  if (stop_requested()) return std::nullopt;
  const TrainConfig shared = with_data(config, options, survey);
  PictureExtent picture{survey.samples, survey.height, survey.width};
  if (options.at) std::tie(picture.width, picture.height) = *options.at;
  const fs::path folder = options.folder();
  make_folder(folder);
  const FileLock lock(folder / ".lock");  // of two searches here, the second waits for what the first finds
  claim(folder, options, shared, picture);

  const std::vector<std::string> looked = sentences(survey);
  for (const std::string& sentence : looked) spdlog::info("{}", sentence);
  const std::vector<Candidate> space = candidate_space(shared, survey);
  Workshop workshop({folder, options.data, program_folder() / "ld_train", picture, options.threads}, space);
  std::optional<SearchOutcome> outcome =
      search(space, options.requirement, options.minutes, workshop.tools());
  if (!outcome) return std::nullopt;
  outcome->sentences.insert(outcome->sentences.begin(), looked.begin(), looked.end());

  const SearchQuestion question{options.data.string(), options.requirement, picture,
                                options.threads,       options.minutes,     workshop.noisy_error()};
  const nlohmann::ordered_json json = to_json(*outcome, question);
  const std::string table = markdown(*outcome, question);
  write_file_atomically(folder / "front.svg", to_svg(figure(*outcome, question)));
  write_file_atomically(folder / "table.md", table);
  write_file_atomically(folder / "table.json", json.dump(2) + "\n");
  std::cout << table << "\n";
  for (const std::string& sentence : outcome->sentences) std::cout << sentence << "\n";
  std::cout << std::flush;
  if (!outcome->chosen) {
    const auto best = std::min_element(outcome->points.begin(), outcome->points.end(),
                                       [](const Point& a, const Point& b) { return a.error < b.error; });
    fail(
        "no model reaches SMAPE {:g} within {:g} minutes of training: the best, {}, has {:.5f}; give a "
        "larger "
        "--target-smape or more --minutes (the table is in {})",
        *options.requirement.target_smape, options.minutes, best->name, best->error, folder.string());
  }
  write_model(options.out, workshop.model_of(outcome->points[*outcome->chosen]), *outcome, question);
  return json;
}

}  // namespace ld
