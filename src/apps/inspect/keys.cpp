#include "apps/inspect/keys.h"

#include <fmt/ranges.h>

#include "core/error.h"
#include "core/text_table.h"
#include "filters/settings.h"
#include "frame/schema.h"
#include "import/mapping.h"
#include "import/view_camera.h"
#include "models/check_network.h"
#include "render/recipe/recipe.h"
#include "training/run/config.h"

namespace ld {
namespace {

/// The names that a registry has, which the description of the key does not say.
std::string names_of(const std::string& key) {
  if (key == "network.name") return fmt::format("{}", fmt::join(network_names(), ", "));
  if (key == "network.features" || key == "network.optional")
    return fmt::format("{}", fmt::join(auto_feature_names(), ", "));
  return "";
}

std::vector<ConfigKey> train_keys() {
  std::vector<ConfigKey> keys = config_keys<TrainConfig>();
  for (ConfigKey& key : keys)
    if (key.allowed.empty()) key.allowed = names_of(key.key);
  return keys;
}

}  // namespace

std::vector<std::string> key_kinds() {
  return {"train", "recipe", "mapping", "camera", "eaw", "svgf"};
}

std::vector<ConfigKey> keys_of(const std::string& kind) {
  if (kind == "train") return train_keys();
  if (kind == "recipe") return config_keys<Recipe>();
  if (kind == "mapping") return config_keys<ImportMapping>();
  if (kind == "camera") return camera_keys();
  if (kind == "eaw") return config_keys<EawSettings>();
  if (kind == "svgf") return config_keys<SvgfSettings>();
  fail_usage("there are no keys of '{}'; choose from {}", kind, fmt::join(key_kinds(), ", "));
}

std::string keys_text(const std::vector<ConfigKey>& keys) {
  std::vector<TableRow> rows = {{"key", "type", "default", "allowed"}};
  for (const ConfigKey& key : keys) rows.push_back({key.key, key.type, key.value, key.allowed});
  return markdown_table(rows, 4);
}

nlohmann::ordered_json keys_json(const std::vector<ConfigKey>& keys) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const ConfigKey& key : keys)
    json.push_back({{"key", key.key}, {"type", key.type}, {"default", key.value}, {"allowed", key.allowed}});
  return json;
}

}  // namespace ld
