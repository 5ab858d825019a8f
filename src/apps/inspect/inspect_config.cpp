#include <algorithm>
#include <initializer_list>
#include <optional>

#include "apps/inspect/inspect.h"
#include "core/error.h"
#include "frame/schema.h"
#include "models/check_network.h"
#include "render/recipe/recipe.h"
#include "training/run/config_file.h"

namespace ld {

namespace {

void add_recipe(Report& report) {
  report.kind = "scene recipe";
  const Recipe recipe = read_recipe(report.path, {}, std::nullopt);
  report.facts["seed"] = recipe.seed;
  report.facts["resolution"] = recipe.resolution;
  report.facts["spp"] = recipe.spp;
  report.facts["frames"] = {
      {"train", recipe.frames.train}, {"validation", recipe.frames.validation}, {"test", recipe.frames.test}};
  report.facts["reference_spp"] = {{"train", recipe.reference_spp.train},
                                   {"validation", recipe.reference_spp.validation},
                                   {"test", recipe.reference_spp.test}};
  double paths = 0;
  for (int64_t frame = 0; frame < recipe.frame_count(); ++frame)
    paths += static_cast<double>(recipe.paths(frame));
  report.facts["camera_paths"] = paths;
}

}  // namespace

void inspect_config(Report& report) {
  report.kind = "YAML file";
  report.attempt([&] {
    ConfigNode root = read_config(report.path);
    if (root.find("base") != nullptr) root = read_train_tree(report.path);
    nlohmann::ordered_json keys = nlohmann::ordered_json::array();
    for (const auto& [key, node] : root.entries) keys.push_back(key);
    report.facts["keys"] = keys;

    const auto has_one_of = [&](std::initializer_list<const char*> names) {
      return std::any_of(names.begin(), names.end(),
                         [&](const char* name) { return root.find(name) != nullptr; });
    };
    if (has_one_of({"resolution", "spp", "reference_spp", "frames", "scenes"})) {
      add_recipe(report);
      return;
    }
    if (!has_one_of({"network", "data", "optimizer", "run", "loss", "epochs"}))
      fail(
          "{}: neither a training config (network, data, optimizer, ...) nor a scene recipe (resolution, "
          "spp, frames, ...)",
          report.path);
    report.kind = "training config";
    const auto config = config_from_tree<TrainConfig>(root);
    NetworkConfig network = config.network;
    if (network.auto_features()) network.features = auto_feature_names();  // any of them may come out
    if (!network.of_init()) check_network(network);
    report.facts["network"] = config.network.name;
    report.facts["features"] = config.network.features;
    report.facts["loss"] = config.loss;
    report.facts["epochs"] = config.epochs;
    if (config.steps > 0) report.facts["steps"] = config.steps;
    report.facts["crop"] = config.data.crop;
    report.facts["batch"] = config.data.batch;
    report.facts["learning_rate"] = config.optimizer.learning_rate;
    report.facts["schedule"] = config.optimizer.schedule;
  });
}

}  // namespace ld
