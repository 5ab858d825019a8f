// What ld_inspect found out about a path.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "doctor/finding.h"

namespace ld {

struct Report {
  std::string path;
  std::string kind;  // "frame", "data set", ...; empty when nothing could be recognised
  nlohmann::ordered_json facts =
      nlohmann::ordered_json::object();  // keys in snake_case, in the order of printing
  std::vector<std::string>
      warnings;  // worth knowing, and dealt with: masked samples, features that are not there
  std::vector<std::string> problems;  // what will fail elsewhere

  std::vector<Finding> findings;  // of the doctor; each stands in warnings or problems as well

  /// Takes over facts and findings.
  void add(const Diagnosis& diagnosis);

  /// Runs `part` of an inspection; an Error that it throws becomes a problem and the inspection goes on.
  void attempt(const std::function<void()>& part);
};

/// For people: kind, facts, warnings and problems, a line each.
std::string report_text(const Report& report);

/// The same for machines: path, kind, facts, warnings, problems, findings (severity, check, text, frames,
/// figures).
nlohmann::ordered_json report_json(const Report& report);

}  // namespace ld
