#include "core/json_text.h"

#include <set>
#include <vector>

#include "core/error.h"

namespace ld {

nlohmann::json parse_json(const std::string& text, const std::string& name) {
  using nlohmann::json;
  constexpr int kDeepest = 32;
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  const auto watch = [&](int depth, json::parse_event_t event, json& parsed) {
    if (depth > kDeepest)
      fail("{}: JSON nested more than {} deep; is it the right kind of file?", name, kDeepest);
    if (event == json::parse_event_t::object_start) keys.emplace_back();
    if (event == json::parse_event_t::object_end) keys.pop_back();
    if (event == json::parse_event_t::key && !keys.back().insert(parsed.get<std::string>()).second)
      fail("{}: duplicate key \"{}\"; remove one of them", name, parsed.get<std::string>());
    return true;
  };
  try {
    return json::parse(text, watch);
  } catch (const json::exception& error) {
    // nlohmann's texts start with "[json.exception.parse_error.101] ".
    const std::string what = error.what();
    const size_t bracket = what.find("] ");
    fail("{}: not valid JSON: {}", name, bracket == std::string::npos ? what : what.substr(bracket + 2));
  }
}

}  // namespace ld
