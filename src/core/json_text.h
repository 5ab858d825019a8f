// JSON from files that may be damaged or hostile.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>

namespace ld {

/// Parses strictly: duplicate keys (nlohmann would keep the last) and nesting beyond 32 levels are errors.
/// `name` is what complaints call the text. Throws Error with the line or byte of the fault.
nlohmann::json parse_json(const std::string& text, const std::string& name);

/// The whole number that an object of `name` holds under `key`: nlohmann would turn 1e300 into any number.
/// Throws Error where there is none, or one beyond 64 bits.
int64_t whole_number(const nlohmann::json& object, const char* key, const std::string& name);

}  // namespace ld
