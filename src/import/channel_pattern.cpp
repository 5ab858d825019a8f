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

/// What one element of a pattern, a character or {sample}, takes from both; nothing where it does not fit.
struct Taken {
  size_t pattern = 0, text = 0;
};

Taken take(std::string_view pattern, std::string_view text, int& sample) {
  if (pattern.substr(0, kSample.size()) == kSample) {
    size_t digits = 0;
    while (digits < text.size() && digits < kMostDigits && is_digit(text[digits])) ++digits;
    if (digits == 0) return {};
    // All digits that are there: sample 1 is not the beginning of sample 10.
    sample = std::stoi(std::string(text.substr(0, digits)));
    return {kSample.size(), digits};
  }
  return !pattern.empty() && !text.empty() && pattern.front() == text.front() ? Taken{1, 1} : Taken{};
}

/// What follows a star begins as early as it fits. Only the last star ever takes more: if what lies between
/// two stars fits early, all later parts have the more text to fit in. So a pattern of stars costs no more
/// than pattern times text.
bool match(std::string_view pattern, std::string_view text, int& sample) {
  size_t at = 0, position = 0;                            // in the pattern and in the text
  size_t after_star = std::string_view::npos, taken = 0;  // the last star's next element; up to where it took
  while (position < text.size() || at < pattern.size()) {
    if (at < pattern.size() && pattern[at] == '*') {
      after_star = ++at;
      taken = position;
      continue;
    }
    if (const Taken fits = take(pattern.substr(at), text.substr(position), sample); fits.pattern > 0) {
      at += fits.pattern;
      position += fits.text;
    } else if (after_star != std::string_view::npos && taken < text.size()) {
      at = after_star;
      position = ++taken;
    } else {
      return false;
    }
  }
  return true;
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
