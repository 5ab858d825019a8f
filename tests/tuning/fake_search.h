// A search whose trainings are a formula: tests of what it decides run in no time.
#pragma once

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "frame/schema.h"
#include "tuning/search.h"

namespace ld {

/// Eight samples a pixel; features that are not in `dropped` vary.
inline DataSurvey fake_survey(const std::set<std::string>& dropped = {}, int samples = 8) {
  DataSurvey survey;
  survey.frames = survey.looked_at = 10;
  survey.width = survey.height = 16;
  survey.samples = samples;
  for (const std::string& name : mh20_feature_names())
    survey.features.push_back({name, dropped.count(name) > 0 ? "it is 0 everywhere" : "", 0});
  return survey;
}

/// Training takes errors of `frames` frames towards those of `quality`; time is `cost`.
struct FakeTools {
  std::map<std::string, double> quality;  // final error by candidate name; others have 0.5
  std::map<std::string, double> gain;     // by feature: what the error is larger without it
  std::map<std::string, double> cost;     // ms by candidate name; others take 10
  double predicted = 1;                   // prediction over cost
  size_t frames = 8;
  double eight_bits_error = 1.001, eight_bits_time = 0.6;
  std::set<std::string> failing;  // trials
  bool failing_in_eight_bits = false;
  size_t stop_after = 1000;  // trials
  std::map<std::string, double> minutes_before = {};
  std::vector<Trial> trials = {};
  std::vector<std::string> measured = {}, in_turns = {};
  double slower_again = 1;  // times in turns over those before

  static std::string key(const NetworkConfig& config) {
    return config.name + (config.means ? "_means" : "") + std::to_string(config.layers) + "_" +
           std::to_string(config.sample_reducer[0]) + "_" + std::to_string(config.kernel_size);
  }
  std::map<std::string, std::string> names = {};  // of candidates by their key

  double ms(const NetworkConfig& config) const {
    const auto found = cost.find(names.at(key(config)));
    return found == cost.end() ? 10 : found->second;
  }
  double error(const Trial& trial) {
    const NetworkConfig& config = trial.config.network;
    const auto found = quality.find(names.at(key(config)));
    double result = found == quality.end() ? 0.5 : found->second;
    for (const auto& [feature, worse] : gain)
      if (std::find(config.features.begin(), config.features.end(), feature) == config.features.end())
        result *= 1 + worse;
    double& minutes = minutes_before[trial.name];
    minutes =
        trial.config.run.minutes + (trial.begins_with.empty() ? 0 : minutes_before.at(trial.begins_with));
    return result * (1 + 0.1 / (1 + minutes));
  }
  SearchTools tools(const std::vector<Candidate>& space) {
    for (const Candidate& candidate : space) names[key(candidate.config.network)] = candidate.name;
    return {[this](const NetworkConfig& config) { return predicted * ms(config); },
            [this](const std::string& name, const NetworkConfig& config,
                   bool eight_bits) -> std::optional<NetworkTime> {
              measured.push_back(name);
              return NetworkTime{(eight_bits ? eight_bits_time : 1) * ms(config), 10};
            },
            [this](const Trial& trial) -> std::optional<TrialResult> {
              if (trials.size() == stop_after) return std::nullopt;
              trials.push_back(trial);
              if (failing.count(trial.name) > 0) return TrialResult{{}, "it diverged"};
              const double mean = error(trial);
              TrialResult result;
              for (size_t f = 0; f < frames; ++f) result.errors.push_back(mean * (1 + 0.1 * double(f)));
              return result;
            },
            [this](const std::string& trial) -> std::optional<EightBits> {
              const auto found =
                  std::find_if(trials.begin(), trials.end(), [&](const Trial& t) { return t.name == trial; });
              if (failing_in_eight_bits) return EightBits{{{}, "they are too coarse"}, {}};
              TrialResult result;
              const double mean = error(*found) * eight_bits_error;
              for (size_t f = 0; f < frames; ++f) result.errors.push_back(mean * (1 + 0.1 * double(f)));
              return EightBits{result, {eight_bits_time * ms(found->config.network), 8}};
            },
            [this](const std::vector<Point>& points) -> std::optional<std::vector<NetworkTime>> {
              std::vector<NetworkTime> times;
              for (const Point& point : points) {
                in_turns.push_back(point.name);
                times.push_back({slower_again * point.time.ms, point.time.memory_mb});
              }
              return times;
            }};
  }
};

}  // namespace ld
