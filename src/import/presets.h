// The mappings of data/import, compiled into the programs so that an installed one needs no files beside it.
#pragma once

#include <string>
#include <vector>

namespace ld {

struct Preset {
  std::string name, text;  // YAML
};

const std::vector<Preset>& presets();

}  // namespace ld
