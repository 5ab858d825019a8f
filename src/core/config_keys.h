// The keys that a configuration takes, from the one description of config_visitor.h: `ld_inspect --keys`
// prints them, and docs/keys.md is made of that.
#pragma once

#include <string>
#include <vector>

#include "core/config_visitor.h"

namespace ld {

struct ConfigKey {
  std::string key;      // with its sections: optimizer.one_cycle.rise; data.paths[].weight in a list of maps
  std::string type;     // "whole number", "list of texts", ...
  std::string value;    // the default, as YAML
  std::string allowed;  // "0 to 1", "at least 1", "adam, adamw"; "": whatever is of the type
};

/// A visitor that reads and writes nothing and notes what it is shown. All of keys() in the order of the
/// description.
class ConfigKeys {
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
    const std::string outer = path_;
    path_ += key + ".";
    value.visit(*this);
    path_ = outer;
  }

  template <class Section>
  void sections(const std::string& key, std::vector<Section>&) {
    keys_.push_back({path_ + key, "list of maps", "[]", ""});
    Section one;
    section(key + "[]", one);
  }

  const std::vector<ConfigKey>& keys() const { return keys_; }

 private:
  template <class Value>
  void add(const std::string& key, const std::string& type, Value& value, const std::string& allowed);

  std::vector<ConfigKey> keys_;
  std::string path_;
};

template <class Config>
std::vector<ConfigKey> config_keys() {
  Config config;
  ConfigKeys visitor;
  config.visit(visitor);
  return visitor.keys();
}

}  // namespace ld
