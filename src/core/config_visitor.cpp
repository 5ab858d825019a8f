#include "core/config_visitor.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/error.h"
#include "core/shown_text.h"

namespace ld {
namespace {

std::string found_text(const ConfigNode& node) {
  if (node.kind == ConfigNode::Kind::list) return "a list";
  if (node.kind == ConfigNode::Kind::map) return "a map";
  return node.text.empty() ? "nothing" : fmt::format("'{}'", shown(node.text));
}

[[noreturn]] void wrong(const ConfigNode& node, const std::string& key, const std::string& expected) {
  fail_usage("{}: {}: expected {}, found {}", node.origin, key, expected, found_text(node));
}

std::string range_text(const std::string& kind, Range range) {
  const Range any;
  if (range.low == any.low && range.high == any.high) return kind;
  if (range.high == any.high) return fmt::format("{} of at least {}", kind, range.low);
  return fmt::format("{} from {} to {}", kind, range.low, range.high);
}

template <class Number>
Number parse_number(const ConfigNode& node, const std::string& key, const std::string& kind, Range range) {
  Number value{};
  const char* end = node.text.data() + node.text.size();
  const auto [stop, error] = std::from_chars(node.text.data(), end, value);
  const bool is_number =
      node.kind == ConfigNode::Kind::scalar && !node.quoted && error == std::errc() && stop == end;
  const auto as_double = static_cast<double>(value);
  if (!is_number || !std::isfinite(as_double) || as_double < range.low || as_double > range.high)
    wrong(node, key, range_text(kind, range));
  return value;
}

template <class Item, class Parse>
std::vector<Item> parse_list(const ConfigNode& node, const std::string& key, const std::string& kind,
                             Parse parse) {
  if (node.kind != ConfigNode::Kind::list) wrong(node, key, "a list of " + kind);
  std::vector<Item> values;
  for (size_t i = 0; i < node.items.size(); ++i)
    values.push_back(parse(node.items[i], fmt::format("{}[{}]", key, i)));
  return values;
}

std::vector<int64_t> parse_integers(const ConfigNode& node, const std::string& key, Range range) {
  return parse_list<int64_t>(node, key, "whole numbers",
                             [&](const ConfigNode& item, const std::string& item_key) {
                               return parse_number<int64_t>(item, item_key, "a whole number", range);
                             });
}

std::string parse_text(const ConfigNode& node, const std::string& key, const Choices& choices) {
  if (node.kind != ConfigNode::Kind::scalar) wrong(node, key, "a text");
  if (!choices.empty() && std::find(choices.begin(), choices.end(), node.text) == choices.end()) {
    const std::string nearest = nearest_word(node.text, choices);
    wrong(node, key,
          fmt::format("one of {}{}", fmt::join(choices, ", "),
                      nearest.empty() ? "" : fmt::format(" (did you mean '{}'?)", nearest)));
  }
  return node.text;
}

/// Quoted whenever plain text could read as something else.
std::string yaml_text(const std::string& text) {
  const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '/' || c == '.' || c == '-';
  }) && std::isalpha(static_cast<unsigned char>(text[0]));
  if (plain) return text;
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') result += '\\';
    if (byte < 32 || byte == 127)
      result += fmt::format("\\x{:02x}", byte);
    else
      result += c;
  }
  return result + "\"";
}

}  // namespace

ConfigReader::ConfigReader(const ConfigNode& node, std::string path) : node_(node), path_(std::move(path)) {
  if (node.kind != ConfigNode::Kind::map)
    wrong(node, path_.substr(0, path_.size() - 1), "a map of 'key: value' lines");
}

const ConfigNode* ConfigReader::take(const std::string& key) {
  known_.push_back(key);
  return node_.find(key);
}

void ConfigReader::field(const std::string& key, bool& value) {
  const ConfigNode* node = take(key);
  if (node == nullptr) return;
  if (node->kind != ConfigNode::Kind::scalar || (node->text != "true" && node->text != "false"))
    wrong(*node, path_ + key, "true or false");
  value = node->text == "true";
}

void ConfigReader::field(const std::string& key, int64_t& value, Range range) {
  if (const ConfigNode* node = take(key))
    value = parse_number<int64_t>(*node, path_ + key, "a whole number", range);
}

void ConfigReader::field(const std::string& key, uint64_t& value) {
  if (const ConfigNode* node = take(key))
    value = parse_number<uint64_t>(*node, path_ + key, "a whole number of at least 0", {});
}

void ConfigReader::field(const std::string& key, double& value, Range range) {
  if (const ConfigNode* node = take(key)) value = parse_number<double>(*node, path_ + key, "a number", range);
}

void ConfigReader::field(const std::string& key, std::string& value, const Choices& choices) {
  if (const ConfigNode* node = take(key)) value = parse_text(*node, path_ + key, choices);
}

void ConfigReader::field(const std::string& key, std::vector<int64_t>& value, Range range) {
  if (const ConfigNode* node = take(key)) value = parse_integers(*node, path_ + key, range);
}

void ConfigReader::field(const std::string& key, std::vector<double>& value, Range range) {
  if (const ConfigNode* node = take(key))
    value = parse_list<double>(*node, path_ + key, "numbers",
                               [&](const ConfigNode& item, const std::string& item_key) {
                                 return parse_number<double>(item, item_key, "a number", range);
                               });
}

void ConfigReader::field(const std::string& key, std::vector<std::vector<int64_t>>& value, Range range) {
  if (const ConfigNode* node = take(key))
    value = parse_list<std::vector<int64_t>>(*node, path_ + key, "lists",
                                             [&](const ConfigNode& item, const std::string& item_key) {
                                               return parse_integers(item, item_key, range);
                                             });
}

void ConfigReader::field(const std::string& key, std::vector<std::string>& value, const Choices& choices) {
  if (const ConfigNode* node = take(key))
    value = parse_list<std::string>(*node, path_ + key, "texts",
                                    [&](const ConfigNode& item, const std::string& item_key) {
                                      return parse_text(item, item_key, choices);
                                    });
}

void ConfigReader::field_or_word(const std::string& key, std::vector<std::string>& value,
                                 const std::string& word) {
  const ConfigNode* node = node_.find(key);
  if (node == nullptr || node->kind != ConfigNode::Kind::scalar) {
    field(key, value);
    return;
  }
  take(key);
  if (node->text != word) wrong(*node, path_ + key, fmt::format("a list of texts or '{}'", word));
  value = {word};
}

const std::vector<ConfigNode>& ConfigReader::maps_of(const ConfigNode& node, const std::string& key) const {
  if (node.kind != ConfigNode::Kind::list) wrong(node, path_ + key, "a list of maps");
  return node.items;
}

void ConfigReader::finish() const {
  for (const auto& [key, node] : node_.entries) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    const std::string nearest = nearest_word(key, known_);
    const std::string advice = nearest.empty() ? "" : fmt::format("did you mean '{}'? ", path_ + nearest);
    fail_usage("{}: unknown key '{}'; {}known here: {}", node.origin, path_ + shown(key), advice,
               fmt::join(known_, ", "));
  }
}

void ConfigWriter::line(const std::string& key, const std::string& value) {
  text_ += fmt::format("{:{}}{}:{}{}\n", "", indent_, key, value.empty() ? "" : " ", value);
}

void ConfigWriter::field(const std::string& key, bool& value) {
  line(key, value ? "true" : "false");
}
void ConfigWriter::field(const std::string& key, int64_t& value, Range) {
  line(key, fmt::format("{}", value));
}
void ConfigWriter::field(const std::string& key, uint64_t& value) {
  line(key, fmt::format("{}", value));
}
void ConfigWriter::field(const std::string& key, double& value, Range) {
  line(key, fmt::format("{}", value));
}
void ConfigWriter::field(const std::string& key, std::string& value, const Choices&) {
  line(key, yaml_text(value));
}
void ConfigWriter::field(const std::string& key, std::vector<int64_t>& value, Range) {
  line(key, fmt::format("[{}]", fmt::join(value, ", ")));
}
void ConfigWriter::field(const std::string& key, std::vector<double>& value, Range) {
  line(key, fmt::format("[{}]", fmt::join(value, ", ")));
}
void ConfigWriter::field(const std::string& key, std::vector<std::vector<int64_t>>& value, Range) {
  std::vector<std::string> lists;
  for (const std::vector<int64_t>& list : value) lists.push_back(fmt::format("[{}]", fmt::join(list, ", ")));
  line(key, fmt::format("[{}]", fmt::join(lists, ", ")));
}
void ConfigWriter::field(const std::string& key, std::vector<std::string>& value, const Choices&) {
  std::vector<std::string> texts;
  for (const std::string& text : value) texts.push_back(yaml_text(text));
  line(key, fmt::format("[{}]", fmt::join(texts, ", ")));
}

void ConfigWriter::field_or_word(const std::string& key, std::vector<std::string>& value,
                                 const std::string& word) {
  if (value == std::vector<std::string>{word})
    line(key, word);
  else
    field(key, value);
}

}  // namespace ld
