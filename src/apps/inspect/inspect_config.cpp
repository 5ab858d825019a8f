#include <algorithm>
#include <initializer_list>

#include "apps/inspect/inspect.h"
#include "core/error.h"
#include "frame/schema.h"
#include "training/config.h"

namespace ld {

void inspect_config(Report& report) {
  report.kind = "YAML file";
  report.attempt([&] {
    const ConfigNode root = read_config(report.path);
    nlohmann::ordered_json keys = nlohmann::ordered_json::array();
    for (const auto& [key, node] : root.entries) keys.push_back(key);
    report.facts["keys"] = keys;

    const auto has_one_of = [&](std::initializer_list<const char*> names) {
      return std::any_of(names.begin(), names.end(),
                         [&](const char* name) { return root.find(name) != nullptr; });
    };
    if (has_one_of({"resolution", "spp", "reference_spp", "frames", "scenes"})) {
      report.kind = "scene recipe";
      report.facts["checked"] = "only that it is sound YAML; ld_render checks the rest when it starts";
      return;
    }
    if (!has_one_of({"network", "data", "optimizer", "run", "loss", "epochs"}))
      fail(
          "{}: neither a training config (network, data, optimizer, ...) nor a scene recipe (resolution, "
          "spp, frames, ...)",
          report.path);
    report.kind = "training config";
    const auto config = config_from_tree<TrainConfig>(root);
    for (const std::string& feature : config.network.features) find_feature(feature);
    report.facts["network"] = config.network.name;
    report.facts["features"] = config.network.features;
    report.facts["loss"] = config.loss;
    report.facts["epochs"] = config.epochs;
    report.facts["crop"] = config.data.crop;
    report.facts["batch"] = config.data.batch;
    report.facts["learning_rate"] = config.optimizer.learning_rate;
    report.facts["schedule"] = config.optimizer.schedule;
  });
}

}  // namespace ld
