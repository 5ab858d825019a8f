// Patterns of channel and part names: `*` stands for any text, {sample} for the digits of a sample's number,
// and " | " separates alternatives.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace ld {

/// The alternatives of a pattern, first choice first.
std::vector<std::string> pattern_alternatives(const std::string& pattern);

struct PatternMatch {
  int sample = -1;  // what stood for {sample}; -1 where the pattern has none
};

/// Whether the whole text is of the pattern (one alternative).
std::optional<PatternMatch> match_pattern(const std::string& pattern, const std::string& text);

/// The pattern with `value` in the place of {layer}.
std::string with_layer(std::string pattern, const std::string& value);

}  // namespace ld
