// JSON from files that may be damaged or hostile.
#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace ld {

/// Parses strictly: duplicate keys (nlohmann would keep the last) and nesting beyond 32 levels are errors.
/// `name` is what complaints call the text. Throws Error with the line or byte of the fault.
nlohmann::json parse_json(const std::string& text, const std::string& name);

}  // namespace ld
