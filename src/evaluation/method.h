// What is evaluated besides the baselines: a name and a function, so that the library knows no inference.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "frame/frame.h"

namespace ld {

struct Method {
  std::string name;
  std::function<Image(const Frame&)> denoise;  // linear radiance [3, H, W] of the frame's size
};

/// "NAME=FILE" of a command line.
struct ModelArgument {
  std::string name, file;
};

/// Throws UsageError for an argument without "=", an empty name or file, and for a bad name (see
/// check_method_names).
std::vector<ModelArgument> parse_model_arguments(const std::vector<std::string>& arguments);

/// Throws UsageError for a name that is empty, given twice, `noisy`, `blur` or `reference` (the tables and
/// pictures use those), or that holds a control character.
void check_method_names(const std::vector<std::string>& names);

}  // namespace ld
