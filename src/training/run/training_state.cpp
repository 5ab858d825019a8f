#include "training/run/training_state.h"

#include <cmath>

#include "core/error.h"
#include "core/json_text.h"

namespace ld {
namespace {

constexpr int kVersion = 2;

/// All whole numbers of a state count something.
int64_t counter(const nlohmann::json& object, const char* key, const std::string& name) {
  const int64_t value = whole_number(object, key, name);
  if (value < 0)
    fail("{}: \"{}\" is {}, expected a whole number from 0; the file was changed or damaged", name, key,
         value);
  return value;
}

}  // namespace

std::string state_to_json(const TrainingState& state) {
  nlohmann::ordered_json json;
  json["version"] = kVersion;
  json["step"] = state.step;
  json["optimizer_steps"] = state.optimizer_steps;
  json["skipped"] = state.skipped;
  json["skipped_in_a_row"] = state.skipped_in_a_row;
  json["loss_sum"] = state.loss_sum;
  json["loss_count"] = state.loss_count;
  json["validation_due"] = state.validation_due;
  json["best_score"] = std::isfinite(state.best_score) ? nlohmann::ordered_json(state.best_score) : nullptr;
  json["best_step"] = state.best_step;
  json["crops_per_step"] = state.crops_per_step;
  json["rollbacks"] = state.rollbacks;
  json["watch"] = {{"losses", state.watch.losses},
                   {"medians", state.watch.medians},
                   {"raised", state.watch.raised},
                   {"window_begin", state.watch.window_begin},
                   {"calm_step", state.watch.calm_step}};
  json["dataset"] = state.dataset;
  return json.dump(2) + "\n";
}

TrainingState state_from_json(const std::string& text, const std::string& name) {
  const nlohmann::json json = parse_json(text, name);
  if (!json.is_object() || json.value("version", nlohmann::json()) != kVersion)
    fail(
        "{}: not the state of a run of this version (expected \"version\": {}); begin a new run, with "
        "init=FOLDER to start from its weights",
        name, kVersion);
  try {
    TrainingState state;
    state.step = counter(json, "step", name);
    state.optimizer_steps = counter(json, "optimizer_steps", name);
    state.skipped = counter(json, "skipped", name);
    state.skipped_in_a_row = counter(json, "skipped_in_a_row", name);
    state.loss_sum = json.at("loss_sum");
    state.loss_count = counter(json, "loss_count", name);
    state.validation_due = json.at("validation_due");
    if (!json.at("best_score").is_null()) state.best_score = json.at("best_score");
    state.best_step = counter(json, "best_step", name);
    state.crops_per_step = counter(json, "crops_per_step", name);
    state.dataset = json.at("dataset");
    if (!json.contains("watch")) return state;  // of an earlier program: the watch begins there
    state.rollbacks = counter(json, "rollbacks", name);
    const nlohmann::json& watch = json.at("watch");
    state.watch.losses = watch.at("losses").get<std::vector<double>>();
    state.watch.medians = watch.at("medians").get<std::vector<double>>();
    state.watch.raised = counter(watch, "raised", name);
    state.watch.window_begin = counter(watch, "window_begin", name);
    state.watch.calm_step = counter(watch, "calm_step", name);
    return state;
  } catch (const nlohmann::json::exception& error) {
    fail("{}: not the state of a training run: {}", name, error.what());
  }
}

}  // namespace ld
