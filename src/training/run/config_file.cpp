#include "training/run/config_file.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "core/file_identity.h"
#include "core/shown_text.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBase = "base";

using Files = std::vector<fs::path>;  // each the base of the one before

void put_on_top(ConfigNode& node, ConfigNode own) {
  if (node.kind != ConfigNode::Kind::map || own.kind != ConfigNode::Kind::map) {
    node = std::move(own);
    return;
  }
  node.origin = own.origin;
  for (auto& [key, value] : own.entries) {
    const auto is_it = [&key = key](const auto& entry) { return entry.first == key; };
    const auto below = std::find_if(node.entries.begin(), node.entries.end(), is_it);
    if (below == node.entries.end())
      node.entries.emplace_back(key, std::move(value));
    else
      put_on_top(below->second, std::move(value));
  }
}

/// Removes a key from the top level.
void drop(ConfigNode& tree, const std::string& key) {
  const auto is_it = [&key](const auto& entry) { return entry.first == key; };
  tree.entries.erase(std::remove_if(tree.entries.begin(), tree.entries.end(), is_it), tree.entries.end());
}

/// The network's name, or `otherwise` where the tree names none.
std::string network_name(const ConfigNode& tree, const std::string& otherwise) {
  const ConfigNode* network = tree.find("network");
  const ConfigNode* name = network != nullptr ? network->find("name") : nullptr;
  return name != nullptr ? name->text : otherwise;
}

fs::path base_of(const ConfigNode& tree, const Files& files) {
  const std::string& origin = tree.find(kBase)->origin;
  std::string name;
  ConfigReader(tree).field(kBase, name);
  const fs::path base = (files.back().parent_path() / name).lexically_normal();
  std::error_code ignored;  // of a name that no file can have
  if (name.empty() || !fs::is_regular_file(base, ignored))
    fail_usage("{}: {}: expected a configuration, by its path from the folder of this file; found no file {}",
               origin, kBase, name.empty() ? "named" : shown(name));
  const FileIdentity identity(base);
  if (std::any_of(files.begin(), files.end(),
                  [&](const fs::path& f) { return FileIdentity(f) == identity; })) {
    std::vector<std::string> names;
    for (const fs::path& file : files) names.push_back(shown(file.string()));
    fail_usage("{}: {}: expected bases of which the last has none, found a circle: {} -> {}", origin, kBase,
               fmt::join(names, " -> "), shown(base.string()));
  }
  return base;
}

ConfigNode read_on_bases(Files& files) {
  ConfigNode own = read_config(files.back());
  if (own.find(kBase) == nullptr) return own;
  files.push_back(base_of(own, files));
  drop(own, kBase);
  ConfigNode tree = read_on_bases(files);
  const std::string name = network_name(tree, NetworkConfig{}.name);
  if (network_name(own, name) != name) drop(tree, "network");
  put_on_top(tree, std::move(own));
  return tree;
}

}  // namespace

ConfigNode read_train_tree(const fs::path& file, const std::vector<std::string>& overrides) {
  Files files = {file};
  ConfigNode tree = read_on_bases(files);
  for (const std::string& assignment : overrides) apply_override(tree, assignment);
  if (const ConfigNode* base = tree.find(kBase))
    fail_usage("{}: {}: expected this key in a file, whose base it names; give another --config",
               base->origin, kBase);
  return tree;
}

std::string place_of(const ConfigNode& tree, const std::string& section, const std::string& key) {
  const ConfigNode* node = tree.find(section);
  if (node != nullptr) node = node->find(key);
  return node != nullptr ? node->origin : "";
}

TrainConfig read_train_config(const fs::path& file, const std::vector<std::string>& overrides) {
  return config_from_tree<TrainConfig>(read_train_tree(file, overrides));
}

}  // namespace ld
