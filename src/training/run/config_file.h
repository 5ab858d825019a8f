// A training configuration as its files say it.
//
// A file may build on another one: `base: quick.yaml` names it, by a path relative to the file that says so.
// What the file itself says then goes on top, map by map; a list replaces a list. A `network:` of another
// name than the base's replaces all of the base's, because sizes that were chosen for one network say
// nothing about another. A base may have a base.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "training/run/config.h"

namespace ld {

/// The file on top of its bases, and "key.sub=value" assignments on top of that, as one tree. Throws Error
/// when the file is missing, UsageError when it or a base is no YAML, when a base is missing, when the bases
/// run in a circle, and for an assignment to `base`. Whether the keys exist is found out when the tree is
/// read into its struct.
ConfigNode read_train_tree(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

/// Which file and line, or the command line, say a key of a section; "" where nothing does.
std::string place_of(const ConfigNode& tree, const std::string& section, const std::string& key);

/// The configuration that the tree holds.
TrainConfig read_train_config(const std::filesystem::path& file,
                              const std::vector<std::string>& overrides = {});

}  // namespace ld
