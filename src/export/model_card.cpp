#include "export/model_card.h"

#include <sstream>

#include "core/error.h"
#include "core/json_text.h"

namespace ld {
namespace {

const std::string& entry(const Metadata& metadata, const std::string& key) {
  const auto found = metadata.find(key);
  if (found == metadata.end()) fail("a model card needs the metadata entry '{}', which is missing", key);
  return found->second;
}

/// Text for a cell of a table.
std::string cell(const nlohmann::json& value) {
  std::string text;
  for (const char c : value.is_string() ? value.get<std::string>() : value.dump()) {
    if (c == '|') text += '\\';
    text += c;
  }
  return text;
}

/// Rows "key | value"; those of nested objects as "outer.inner".
void add_rows(std::string& text, const nlohmann::json& json, const std::string& prefix) {
  for (const auto& item : json.items()) {
    const std::string key = prefix + item.key();
    if (item.value().is_object())
      add_rows(text, item.value(), key + ".");
    else
      text += fmt::format("| {} | {} |\n", key, cell(item.value()));
  }
}

std::string table(const Metadata& metadata, const std::string& key) {
  const std::string& text = entry(metadata, key);
  if (text.empty()) return "Nothing is known.\n";
  std::string rows = "| | |\n| --- | --- |\n";
  add_rows(rows, parse_json(text, key), "");
  return rows;
}

}  // namespace

std::string model_card(const std::string& title, const Metadata& metadata) {
  std::string features;
  std::istringstream lines(entry(metadata, "features"));
  for (std::string line; std::getline(lines, line);) features += "- " + line + "\n";
  return fmt::format(
      "# {}\n\nDenoises path-traced pictures from their samples.\n\n"
      "## Reads\n\nFeatures of each sample, in this order: name, channels, encoding, scale.\n\n{}\n"
      "## Where it came from\n\n{}\n## Measured at the export\n\n{}\n## Network\n\n```yaml\n{}```\n",
      title, features, table(metadata, "provenance"), table(metadata, "export"), entry(metadata, "network"));
}

}  // namespace ld
