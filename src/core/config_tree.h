// A YAML file as a tree that remembers where each value stands, so that every complaint can name its line.
// Stricter than YAML: duplicate keys, anchors, aliases, tags and several documents are errors (yaml-cpp
// accepts the first and expands the others without limit).
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace ld {

struct ConfigNode {
  enum class Kind { scalar, list, map };

  Kind kind = Kind::map;
  std::string text;                                         // of a scalar
  bool quoted = false;                                      // a scalar that YAML says is a string
  std::vector<ConfigNode> items;                            // of a list
  std::vector<std::pair<std::string, ConfigNode>> entries;  // of a map, in the file's order
  std::string origin;                                       // "configs/quick.yaml:12" or "command line"

  const ConfigNode* find(const std::string& key) const;
};

/// Parses YAML text; `name` is what complaints call it. An empty text is an empty map. Throws UsageError.
ConfigNode parse_config(const std::string& text, const std::string& name);

/// Reads a YAML file of at most 1 MB. Throws Error when it is missing, UsageError when it is not YAML.
ConfigNode read_config(const std::filesystem::path& path);

/// Applies "key.sub=value" (value: any YAML in one line) on top of the tree. Whether the key exists is found
/// out when the tree is read into its struct. Throws UsageError when the text is no assignment.
void apply_override(ConfigNode& root, const std::string& assignment);

}  // namespace ld
