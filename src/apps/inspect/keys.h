// The keys of the project's YAML files, for `ld_inspect --keys`.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/config_keys.h"

namespace ld {

/// What keys_of() knows: training configurations, recipes, mappings of ld_import and its camera files.
std::vector<std::string> key_kinds();

/// All keys of a kind of file. Throws UsageError for another kind.
std::vector<ConfigKey> keys_of(const std::string& kind);

/// A table: key, type, default, what is allowed.
std::string keys_text(const std::vector<ConfigKey>& keys);
nlohmann::ordered_json keys_json(const std::vector<ConfigKey>& keys);

}  // namespace ld
