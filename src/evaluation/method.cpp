#include "evaluation/method.h"

#include <algorithm>

#include "core/error.h"

namespace ld {

std::vector<ModelArgument> parse_model_arguments(const std::vector<std::string>& arguments) {
  return parse_named_arguments("--model", "layer=weights.safetensors", arguments);
}

std::vector<ModelArgument> parse_named_arguments(const std::string& option, const std::string& example,
                                                 const std::vector<std::string>& arguments) {
  std::vector<ModelArgument> parsed;
  std::vector<std::string> names;
  for (const std::string& argument : arguments) {
    const size_t equals = argument.find('=');
    if (equals == std::string::npos || equals + 1 == argument.size())
      fail_usage("{} {}: expected NAME={}, for instance {}", option, argument,
                 option == "--model" ? "FILE" : "DIR", example);
    parsed.push_back({argument.substr(0, equals), argument.substr(equals + 1)});
    names.push_back(parsed.back().name);
  }
  check_method_names(names);
  return parsed;
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

void check_baseline(const std::string& baseline, const std::vector<Method>& methods) {
  std::vector<std::string> names = {"noisy", "blur"};
  for (const Method& method : methods) names.push_back(method.name);
  if (!baseline.empty() && std::find(names.begin(), names.end(), baseline) == names.end())
    fail_usage("--baseline {}: no such method; there are {}", baseline, fmt::join(names, ", "));
}

}  // namespace ld
