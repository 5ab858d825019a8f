#include "apps/inspect/inspect_report.h"

#include <algorithm>

#include "core/error.h"

namespace ld {
namespace {

using Json = nlohmann::ordered_json;

std::string value_text(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_null()) return "unknown";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  if (!value.is_array()) return value.dump();
  std::string list;
  for (const Json& item : value)
    list += (list.empty() ? "" : ", ") + (item.is_array() ? item.dump() : value_text(item));
  return list.empty() ? "none" : list;
}

void add_facts(std::string& text, const Json& facts, const std::string& indent) {
  for (const auto& [key, value] : facts.items()) {
    std::string name = key;
    std::replace(name.begin(), name.end(), '_', ' ');
    if (value.is_object()) {
      text += indent + name + (value.empty() ? ": none\n" : ":\n");
      add_facts(text, value, indent + "  ");
    } else {
      text += indent + name + ": " + value_text(value) + "\n";
    }
  }
}

}  // namespace

void Report::attempt(const std::function<void()>& part) {
  try {
    part();
  } catch (const Error& error) {
    problems.emplace_back(error.what());
  }
}

void Report::add(const Diagnosis& diagnosis) {
  for (const auto& [key, value] : diagnosis.facts.items()) facts[key] = value;
  for (const Finding& finding : diagnosis.findings) {
    (finding.severity == Severity::problem ? problems : warnings)
        .push_back(finding.check + ": " + finding.text);
    findings.push_back(finding);
  }
}

std::string report_text(const Report& report) {
  std::string text = report.path + ": " + (report.kind.empty() ? "not recognised" : report.kind) + "\n";
  add_facts(text, report.facts, "  ");
  for (const std::string& warning : report.warnings) text += "  warning: " + warning + "\n";
  for (const std::string& problem : report.problems) text += "  problem: " + problem + "\n";
  if (report.problems.empty() && report.warnings.empty()) text += "  nothing is wrong with it\n";
  if (report.problems.empty() && !report.warnings.empty())
    text += fmt::format("  no problem, {} warning{}\n", report.warnings.size(),
                        report.warnings.size() == 1 ? "" : "s");
  return text;
}

Json report_json(const Report& report) {
  Json findings = Json::array();
  for (const Finding& finding : report.findings)
    findings.push_back({{"severity", severity_name(finding.severity)},
                        {"check", finding.check},
                        {"text", finding.text},
                        {"frames", finding.frames},
                        {"figures", finding.figures}});
  return {{"path", report.path},         {"kind", report.kind.empty() ? Json() : Json(report.kind)},
          {"facts", report.facts},       {"warnings", report.warnings},
          {"problems", report.problems}, {"findings", findings}};
}

}  // namespace ld
