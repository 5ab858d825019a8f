// Reading a glTF file's JSON without trusting it.
#pragma once

#include <nlohmann/json.hpp>

#include <cmath>
#include <string>
#include <utility>

#include "core/error.h"
#include "render/geometry/vec3.h"

namespace ld {

/// An entry of the JSON with complaints that name the place.
class GltfItem {
 public:
  GltfItem(const nlohmann::json& value, std::string where) : value_(value), where_(std::move(where)) {}

  /// The member, or null's item when it is not there.
  GltfItem operator[](const char* key) const {
    static const nlohmann::json nothing;
    if (value_.is_null()) return {nothing, where_};
    if (!value_.is_object()) wrong("an object");
    const auto it = value_.find(key);
    return {it == value_.end() ? nothing : *it, where_ + "." + key};
  }
  bool there() const { return !value_.is_null(); }
  size_t size() const {
    if (there() && !value_.is_array()) wrong("a list");
    return value_.size();
  }
  GltfItem at(size_t index) const { return {value_.at(index), fmt::format("{}[{}]", where_, index)}; }
  /// The item of `list` that this index names.
  GltfItem in(const GltfItem& list) const {
    if (!value_.is_number_unsigned() || value_.get<size_t>() >= list.size())
      wrong(fmt::format("an index below {}", list.size()));
    return list.at(value_.get<size_t>());
  }
  float number(float fallback) const {
    if (!there()) return fallback;
    if (!value_.is_number() || !std::isfinite(value_.get<float>())) wrong("a number");
    return value_.get<float>();
  }
  /// A whole number from 0 to 2^40, more than any file holds.
  uint64_t whole(uint64_t fallback) const {
    if (!there()) return fallback;
    if (!value_.is_number_unsigned() || value_.get<uint64_t>() > (uint64_t{1} << 40)) wrong("a whole number");
    return value_.get<uint64_t>();
  }
  std::string text(const std::string& fallback) const {
    if (!there()) return fallback;
    if (!value_.is_string()) wrong("a text");
    return value_.get<std::string>();
  }
  Vec3 colour(Vec3 fallback) const {
    if (!there()) return fallback;
    if (value_.is_number()) return grey(number(0));
    if (size() != 3) wrong("three numbers");
    return {at(0).number(0), at(1).number(0), at(2).number(0)};
  }
  [[noreturn]] void wrong(const std::string& expected) const {
    std::string found = value_.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    if (found.size() > 60) found = found.substr(0, 60) + "...";
    fail("{}: expected {}, found {}", where_, expected, found);
  }

 private:
  const nlohmann::json& value_;
  std::string where_;
};

}  // namespace ld
