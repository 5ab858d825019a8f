#include "core/config_keys.h"

#include <fmt/ranges.h>

namespace ld {
namespace {

std::string range_text(Range range) {
  const Range any;
  const bool low = range.low != any.low, high = range.high != any.high;
  if (low && high) return fmt::format("{} to {}", range.low, range.high);
  if (low) return fmt::format("at least {}", range.low);
  return high ? fmt::format("at most {}", range.high) : "";
}

std::string choices_text(const Choices& choices) {
  return fmt::format("{}", fmt::join(choices, ", "));
}

}  // namespace

template <class Value>
void ConfigKeys::add(const std::string& key, const std::string& type, Value& value,
                     const std::string& allowed) {
  ConfigWriter writer;
  writer.field("", value);  // ": VALUE\n"
  const std::string& text = writer.text();
  keys_.push_back({path_ + key, type, text.substr(2, text.size() - 3), allowed});
}

void ConfigKeys::field(const std::string& key, bool& value) {
  add(key, "true or false", value, "");
}
void ConfigKeys::field(const std::string& key, int64_t& value, Range range) {
  add(key, "whole number", value, range_text(range));
}
void ConfigKeys::field(const std::string& key, uint64_t& value) {
  add(key, "whole number", value, range_text(at_least(0)));
}
void ConfigKeys::field(const std::string& key, double& value, Range range) {
  add(key, "number", value, range_text(range));
}
void ConfigKeys::field(const std::string& key, std::string& value, const Choices& choices) {
  add(key, "text", value, choices_text(choices));
}
void ConfigKeys::field(const std::string& key, std::vector<int64_t>& value, Range range) {
  add(key, "list of whole numbers", value, range_text(range));
}
void ConfigKeys::field(const std::string& key, std::vector<double>& value, Range range) {
  add(key, "list of numbers", value, range_text(range));
}
void ConfigKeys::field(const std::string& key, std::vector<std::vector<int64_t>>& value, Range range) {
  add(key, "list of lists of whole numbers", value, range_text(range));
}
void ConfigKeys::field(const std::string& key, std::vector<std::string>& value, const Choices& choices) {
  add(key, "list of texts", value, choices_text(choices));
}
void ConfigKeys::field_or_word(const std::string& key, std::vector<std::string>& value,
                               const std::string& word) {
  add(key, fmt::format("list of texts, or {}", word), value, "");
}

}  // namespace ld
