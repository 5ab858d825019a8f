// A configuration is a plain struct with defaults and one member template that names its fields:
//
//   struct AdamConfig {
//     double learning_rate = 0.005;
//     template <class Visitor> void visit(Visitor& v) { v.field("learning_rate", learning_rate, at_least(0));
//     }
//   };
//
// From that one description come the strict reader (unknown, duplicated or ill-typed keys, values out of
// range) and the writer of the resolved configuration.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "core/config_tree.h"

namespace ld {

/// The closed interval that a number must lie in.
struct Range {
  double low = -std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::max();
};
inline Range at_least(double low) {
  return {low, std::numeric_limits<double>::max()};
}

using Choices = std::vector<std::string>;  // empty: any text

/// Fills a struct from a map node; keys that the file leaves out keep their defaults. All complaints are
/// UsageError.
class ConfigReader {
 public:
  explicit ConfigReader(const ConfigNode& node, std::string path = "");

  void field(const std::string& key, bool& value);
  void field(const std::string& key, int64_t& value, Range range = {});
  void field(const std::string& key, uint64_t& value);
  void field(const std::string& key, double& value, Range range = {});
  void field(const std::string& key, std::string& value, const Choices& choices = {});
  void field(const std::string& key, std::vector<int64_t>& value, Range range = {});
  void field(const std::string& key, std::vector<double>& value, Range range = {});
  void field(const std::string& key, std::vector<std::vector<int64_t>>& value, Range range = {});
  void field(const std::string& key, std::vector<std::string>& value, const Choices& choices = {});
  /// A list of texts, or `word` alone, which becomes {word}.
  void field_or_word(const std::string& key, std::vector<std::string>& value, const std::string& word);

  template <class Section>
  void section(const std::string& key, Section& value) {
    if (const ConfigNode* node = take(key)) {
      ConfigReader reader(*node, path_ + key + ".");
      value.visit(reader);
      reader.finish();
    }
  }

  /// A list of maps, each a Section.
  template <class Section>
  void sections(const std::string& key, std::vector<Section>& values) {
    const ConfigNode* node = take(key);
    if (node == nullptr) return;
    values.clear();
    for (const ConfigNode& item : maps_of(*node, key)) {
      ConfigReader reader(item, path_ + key + "[" + std::to_string(values.size()) + "].");
      values.emplace_back().visit(reader);
      reader.finish();
    }
  }

  /// Call after the last field: a key that no field asked for is an error with the nearest known key.
  void finish() const;

 private:
  const ConfigNode* take(const std::string& key);
  const std::vector<ConfigNode>& maps_of(const ConfigNode& node, const std::string& key) const;

  const ConfigNode& node_;
  std::string path_;
  std::vector<std::string> known_;
};

/// Writes a struct as YAML text that ConfigReader reads back to the same values.
class ConfigWriter {
 public:
  void field(const std::string& key, bool& value);
  void field(const std::string& key, int64_t& value, Range range = {});
  void field(const std::string& key, uint64_t& value);
  void field(const std::string& key, double& value, Range range = {});
  void field(const std::string& key, std::string& value, const Choices& choices = {});
  void field(const std::string& key, std::vector<int64_t>& value, Range range = {});
  void field(const std::string& key, std::vector<double>& value, Range range = {});
  void field(const std::string& key, std::vector<std::vector<int64_t>>& value, Range range = {});
  void field(const std::string& key, std::vector<std::string>& value, const Choices& choices = {});
  void field_or_word(const std::string& key, std::vector<std::string>& value, const std::string& word);

  template <class Section>
  void section(const std::string& key, Section& value) {
    line(key, "");
    indent_ += 2;
    value.visit(*this);
    indent_ -= 2;
  }

  template <class Section>
  void sections(const std::string& key, std::vector<Section>& values) {
    line(key, values.empty() ? "[]" : "");
    for (Section& value : values) {
      const size_t dash = text_.size() + indent_ + 2;
      indent_ += 4;
      value.visit(*this);
      indent_ -= 4;
      text_[dash] = '-';
    }
  }

  const std::string& text() const { return text_; }

 private:
  void line(const std::string& key, const std::string& value);

  std::string text_;
  size_t indent_ = 0;
};

template <class Config>
Config config_from_tree(const ConfigNode& root) {
  Config config;
  ConfigReader reader(root);
  config.visit(reader);
  reader.finish();
  return config;
}

template <class Config>
std::string config_to_yaml(Config config) {
  ConfigWriter writer;
  config.visit(writer);
  return writer.text();
}

}  // namespace ld
