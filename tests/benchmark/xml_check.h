// Whether a text is well-formed XML, as far as the figures use it: elements, attributes, the entities of
// escaped texts.
#pragma once

#include <regex>
#include <string>
#include <vector>

namespace ld {

/// Empty when the text is well formed, else what is wrong with it.
inline std::string xml_fault(const std::string& text) {
  static const std::regex tag(R"(<(/?)([a-zA-Z]+)((?:\s+[a-zA-Z0-9_:-]+="[^"<]*")*)\s*(/?)>)");
  static const std::regex stray("[<>]|&(?!(amp|lt|gt|quot|apos);)");
  std::vector<std::string> open;
  bool closed = false;  // the root element
  auto at = text.cbegin();
  for (std::smatch found; at != text.cend() && std::regex_search(at, text.cend(), found, tag);) {
    const std::string between(at, found[0].first);
    if (std::regex_search(between, stray)) return "stray character in '" + between + "'";
    if (open.empty() && between.find_first_not_of(" \n") != std::string::npos) return "text outside the root";
    if (closed) return "a second root element <" + found.str(2) + ">";
    if (found.length(1) > 0) {
      if (open.empty() || open.back() != found.str(2)) return "</" + found.str(2) + "> closes nothing";
      open.pop_back();
    } else if (found.length(4) == 0) {
      open.push_back(found.str(2));
    }
    closed = open.empty();
    at = found[0].second;
  }
  if (!open.empty()) return "<" + open.back() + "> is not closed";
  if (!closed) return "no element";
  return std::string(at, text.cend()).find_first_not_of(" \n") == std::string::npos ? "" : "text at the end";
}

}  // namespace ld
