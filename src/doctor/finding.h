// What the doctor says about a data set.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace ld {

enum class Severity {
  warning,  // worth knowing; training works
  problem,  // a network that learns from this learns something wrong, or training fails
};

/// One fault: what it is with its figures, and what to do about it.
struct Finding {
  Severity severity = Severity::warning;
  std::string check;                // by its name in check_names(), such as "normals"
  std::string text;                 // one line: figures and advice
  std::vector<std::string> frames;  // those that have it; empty when it concerns the data set
  nlohmann::ordered_json figures = nlohmann::ordered_json::object();  // the numbers of the text
};

struct Diagnosis {
  nlohmann::ordered_json facts = nlohmann::ordered_json::object();  // ranges, what varies, what was looked at
  std::vector<Finding> findings;

  /// `check` is filled in by whoever runs the checks.
  void add(Severity severity, std::string text, std::vector<std::string> frames,
           nlohmann::ordered_json figures) {
    findings.push_back({severity, "", std::move(text), std::move(frames), std::move(figures)});
  }
};

/// "warning" or "problem".
const char* severity_name(Severity severity);

/// "3 of 65 frames (frame_000001, frame_000007, frame_000012)", at most three of them by name.
std::string frames_text(const std::vector<std::string>& names, size_t of);

/// "0.0034 %": three digits, never 0 for what is more than nothing.
std::string share_text(double part, double whole);

}  // namespace ld
