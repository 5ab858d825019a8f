#include "tuning/workshop.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.h"
#include "core/file_io.h"
#include "core/json_text.h"
#include "core/log.h"
#include "core/process/child_process.h"
#include "core/signals.h"
#include "evaluation/data_set.h"
#include "export/quantised_export.h"
#include "inference/model_method.h"
#include "metrics/smape.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

constexpr int64_t kCalibrationSide = 256;  // of the frames that rates are measured on
constexpr int kWrongConfiguration = 2;     // exit code of our programs

nlohmann::json read_json(const fs::path& path) {
  return parse_json(read_file(path), path.string());
}

CostModel read_rates(const nlohmann::json& json) {
  std::map<size_t, double> rates;
  for (const auto& [op, rate] : json.at("seconds_a_unit").items()) rates[std::stoul(op)] = rate;
  return CostModel(rates);
}

/// One graph of each kind of network.
CostModel calibrate(const std::vector<Candidate>& space, const WorkshopOptions& options) {
  std::vector<NetworkConfig> graphs;
  std::set<std::string> kinds;
  for (const Candidate& candidate : space)
    if (kinds.insert(candidate.config.network.name).second) graphs.push_back(candidate.config.network);
  const PictureExtent& picture = options.picture;
  return CostModel(graphs,
                   {picture.samples, std::min(picture.height, kCalibrationSide),
                    std::min(picture.width, kCalibrationSide)},
                   options.threads);
}

std::string last_line(const fs::path& log) {
  std::string text = read_file(log);
  text.erase(text.find_last_not_of(" \n") + 1);
  return text.substr(text.rfind('\n') + 1);
}

void record(const fs::path& path, const TrialResult& result) {
  nlohmann::ordered_json json;
  if (result.failure.empty())
    json["smape"] = result.errors;
  else
    json["failure"] = result.failure;
  write_file_atomically(path, json.dump(2) + "\n");
}

TrialResult read_record(const fs::path& path) {
  const nlohmann::json json = read_json(path);
  try {
    if (json.contains("failure")) return {{}, json.at("failure")};
    return {json.at("smape"), ""};
  } catch (const nlohmann::json::exception& error) {
    fail("{}: expected what a trial scored: {}; remove it to score the trial again", path.string(),
         error.what());
  }
}

}  // namespace

Workshop::Workshop(const WorkshopOptions& options, const std::vector<Candidate>& space)
    : options_(options), costs_(std::map<size_t, double>{}) {
  make_folder(options_.folder / "trials");
  const fs::path path = options_.folder / "costs.json";
  if (!fs::exists(path)) {
    costs_ = calibrate(space, options_);
    remember_costs();
    return;
  }
  const nlohmann::json json = read_json(path);
  try {
    costs_ = read_rates(json);
    for (const auto& [name, time] : json.at("times").items())
      times_[name] = {time.at("ms"), time.at("memory_mb")};
  } catch (const nlohmann::json::exception& error) {
    fail("{}: expected rates and times: {}; remove it to measure them again", path.string(), error.what());
  }
}

void Workshop::remember_costs() const {
  nlohmann::ordered_json json = {{"seconds_a_unit", nlohmann::json::object()},
                                 {"times", nlohmann::json::object()}};
  for (const auto& [op, rate] : costs_.rates()) json["seconds_a_unit"][std::to_string(op)] = rate;
  for (const auto& [name, time] : times_)
    json["times"][name] = {{"ms", time.ms}, {"memory_mb", time.memory_mb}};
  write_file_atomically(options_.folder / "costs.json", json.dump(2) + "\n");
}

SearchTools Workshop::tools() {
  return {[this](const NetworkConfig& config) { return costs_.milliseconds(config, options_.picture); },
          [this](const std::string& name, const NetworkConfig& config, bool eight_bits) {
            return eight_bits ? measure(name + " in 8 bits", random_weights_in_eight_bits(config))
                              : measure(name, random_weights(config));
          },
          [this](const Trial& trial) { return run(trial); },
          [this](const std::string& trial) { return in_eight_bits(trial); },
          [this](const std::vector<Point>& points) { return measure_in_turns(points); }};
}

fs::path Workshop::place(const std::string& trial, const std::string& extension) const {
  return options_.folder / "trials" / (trial + extension);
}

fs::path Workshop::model_of(const Point& point) const {
  return place(point.trial, point.eight_bits ? ".i8.safetensors" : "");
}

std::optional<NetworkTime> Workshop::measure(const std::string& name, const NetworkWeights& network) {
  if (stop_requested()) return std::nullopt;
  const auto found = times_.find(name);
  if (found != times_.end()) return found->second;
  const NetworkTime time = measure_network(network, options_.picture, options_.threads);
  spdlog::info("{}: {:.3g} ms a frame, predicted {:.3g}", name, time.ms,
               costs_.milliseconds(network.config, options_.picture));
  times_[name] = time;
  remember_costs();
  return time;
}

std::optional<std::vector<NetworkTime>> Workshop::measure_in_turns(const std::vector<Point>& points) {
  if (stop_requested()) return std::nullopt;
  std::vector<NetworkWeights> networks;
  std::vector<std::string> names;
  for (const Point& point : points) {
    networks.push_back(point.eight_bits ? read_network_weights(model_of(point))
                                        : random_weights(point.candidate.config.network));
    names.push_back(point.name + ", in turns");
  }
  if (std::any_of(names.begin(), names.end(), [&](const auto& name) { return times_.count(name) == 0; })) {
    const std::vector<NetworkTime> times = measure_networks(networks, options_.picture, options_.threads);
    for (size_t i = 0; i < names.size(); ++i) times_[names[i]] = times[i];
    remember_costs();
  }
  std::vector<NetworkTime> found;
  for (const std::string& name : names) found.push_back(times_.at(name));
  return found;
}

std::optional<TrialResult> Workshop::score(const fs::path& model, const fs::path& path) {
  const LoadedModel loaded = load_model({path.stem().string(), model.string()}, options_.threads);
  const FrameSet frames = open_frame_set(options_.data, "validation", loaded.denoiser->features(), 0,
                                         int(options_.picture.samples));
  TrialResult result;
  for (size_t i = 0; i < frames.count; ++i) {
    if (stop_requested()) return std::nullopt;
    const EvaluationFrame frame = frames.load(i);
    result.errors.push_back(smape(denoise(loaded, frame.frame), frame.reference));
    if (std::isfinite(result.errors.back())) continue;
    result = {{}, fmt::format("its picture of {} is not finite", frame.name)};
    break;
  }
  record(path, result);
  return result;
}

std::optional<TrialResult> Workshop::run(const Trial& trial) {
  if (stop_requested()) return std::nullopt;
  const fs::path scores = place(trial.name, ".json"), config = place(trial.name, ".yaml"),
                 log = place(trial.name, ".log"), run = place(trial.name);
  if (fs::exists(scores)) return read_record(scores);
  TrainConfig resolved = trial.config;
  if (!trial.begins_with.empty()) resolved.init = place(trial.begins_with).string();
  write_file_atomically(config, config_to_yaml(resolved));
  spdlog::info("training {}", run.string());
  const int code = run_child({options_.trainer.string(), "--config", config.string(), "--threads",
                              std::to_string(options_.threads), "--out", run.string()},
                             log);
  if (stop_requested()) return std::nullopt;
  if (code == 0) return score(run, scores);
  const std::string why = last_line(log);
  if (code == kWrongConfiguration) fail_usage("{}", why);
  if (code > 128)
    fail("{} ended by signal {}: {}; the same command goes on from there", run.string(), code - 128, why);
  record(scores, {{}, why});
  return read_record(scores);
}

std::optional<EightBits> Workshop::in_eight_bits(const std::string& trial) {
  if (stop_requested()) return std::nullopt;
  const fs::path file = place(trial, ".i8.safetensors"), scores = place(trial, ".i8.json");
  if (!fs::exists(scores)) {
    try {
      export_quantised({place(trial), options_.data, file, 1, options_.threads});
    } catch (const Error& error) {
      record(scores, {{}, error.what()});
      return EightBits{read_record(scores), {}};
    }
    if (!score(file, scores)) return std::nullopt;
  }
  const TrialResult result = read_record(scores);
  if (!result.failure.empty()) return EightBits{result, {}};
  const auto time = measure(trial + " in 8 bits", read_network_weights(file));
  if (!time) return std::nullopt;
  return EightBits{result, *time};
}

double Workshop::noisy_error() const {
  const FrameSet frames =
      open_frame_set(options_.data, "validation", {"radiance"}, 0, int(options_.picture.samples));
  double sum = 0;
  for (size_t i = 0; i < frames.count; ++i) {
    const EvaluationFrame frame = frames.load(i);
    sum += smape(mean_radiance(frame.frame), frame.reference);
  }
  return sum / double(frames.count);
}

}  // namespace ld
