#include "import/channel_pattern.h"

#include <algorithm>
#include <string_view>

namespace ld {
namespace {

constexpr std::string_view kSample = "{sample}";
constexpr size_t kMostDigits = 6;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Backtracking is harmless: patterns are the user's own and channel names at most 255 bytes long.
bool match(std::string_view pattern, std::string_view text, int& sample) {
  if (pattern.empty()) return text.empty();
  if (pattern.front() == '*') {
    for (size_t skipped = 0; skipped <= text.size(); ++skipped)
      if (match(pattern.substr(1), text.substr(skipped), sample)) return true;
    return false;
  }
  if (pattern.substr(0, kSample.size()) == kSample) {
    size_t digits = 0;
    while (digits < text.size() && digits < kMostDigits && is_digit(text[digits])) ++digits;
    // All digits that are there: sample 1 is not the beginning of sample 10.
    if (digits == 0 || !match(pattern.substr(kSample.size()), text.substr(digits), sample)) return false;
    sample = std::stoi(std::string(text.substr(0, digits)));
    return true;
  }
  return !text.empty() && text.front() == pattern.front() && match(pattern.substr(1), text.substr(1), sample);
}

}  // namespace

std::vector<std::string> pattern_alternatives(const std::string& pattern) {
  std::vector<std::string> alternatives;
  const std::string separator = " | ";
  for (size_t begin = 0; begin <= pattern.size();) {
    const size_t end = std::min(pattern.find(separator, begin), pattern.size());
    alternatives.push_back(pattern.substr(begin, end - begin));
    begin = end + separator.size();
  }
  return alternatives;
}

std::optional<PatternMatch> match_pattern(const std::string& pattern, const std::string& text) {
  PatternMatch result;
  if (!match(pattern, text, result.sample)) return std::nullopt;
  return result;
}

std::string with_layer(std::string pattern, const std::string& value) {
  const std::string layer = "{layer}";
  for (size_t at = pattern.find(layer); at != std::string::npos; at = pattern.find(layer, at + value.size()))
    pattern.replace(at, layer.size(), value);
  return pattern;
}

}  // namespace ld
