#include "evaluation/method.h"

#include <algorithm>

#include "core/error.h"

namespace ld {

std::vector<ModelArgument> parse_model_arguments(const std::vector<std::string>& arguments) {
  std::vector<ModelArgument> models;
  std::vector<std::string> names;
  for (const std::string& argument : arguments) {
    const size_t equals = argument.find('=');
    if (equals == std::string::npos || equals + 1 == argument.size())
      fail_usage("--model {}: expected NAME=FILE, for instance layer=weights.safetensors", argument);
    models.push_back({argument.substr(0, equals), argument.substr(equals + 1)});
    names.push_back(models.back().name);
  }
  check_method_names(names);
  return models;
}

void check_method_names(const std::vector<std::string>& names) {
  for (auto name = names.begin(); name != names.end(); ++name) {
    if (name->empty()) fail_usage("a method without a name; expected NAME=FILE with a name before the '='");
    for (const char* reserved : {"noisy", "blur", "reference"})
      if (*name == reserved)
        fail_usage("a method may not be named '{}': the tables use that name; choose another", *name);
    if (std::find(names.begin(), name, *name) != name)
      fail_usage("two methods are named '{}'; rename one", *name);
    if (std::any_of(name->begin(), name->end(), [](char c) { return static_cast<unsigned char>(c) < 32; }))
      fail_usage("the name of a method holds a control character; expected printable text");
  }
}

}  // namespace ld
