#include "core/json_text.h"

#include <set>
#include <vector>

#include "core/error.h"
#include "core/shown_text.h"

namespace ld {
namespace {

using nlohmann::json;

/// Looks for what json::parse() lets pass. (Its own callback takes time that grows with the square of the
/// number of objects in an object.)
class Watcher : public nlohmann::json_sax<json> {
 public:
  explicit Watcher(const std::string& name) : name_(name) {}

  bool start_object(std::size_t) override {
    keys_.emplace_back();
    return enter();
  }
  bool end_object() override {
    keys_.pop_back();
    return leave();
  }
  bool start_array(std::size_t) override { return enter(); }
  bool end_array() override { return leave(); }
  bool key(string_t& key) override {
    if (!keys_.back().insert(key).second)
      fail("{}: duplicate key \"{}\"; remove one of them", name_, shown(key));
    return true;
  }
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  /// json::parse() meets the same error and says it.
  bool parse_error(std::size_t, const std::string&, const json::exception&) override { return false; }

 private:
  bool enter() {
    constexpr int kDeepestNesting = 32;
    if (++depth_ > kDeepestNesting)
      fail("{}: JSON nested more than {} deep; is it the right kind of file?", name_, kDeepestNesting);
    return true;
  }
  bool leave() {
    --depth_;
    return true;
  }

  const std::string& name_;
  std::vector<std::set<std::string>> keys_;  // of the objects that are open
  int depth_ = 0;
};

}  // namespace

json parse_json(const std::string& text, const std::string& name) {
  try {
    Watcher watcher(name);
    json::sax_parse(text, &watcher);
    return json::parse(text);
  } catch (const json::exception& error) {
    // nlohmann's texts start with "[json.exception.parse_error.101] ".
    const std::string what = error.what();
    const size_t bracket = what.find("] ");
    fail("{}: not valid JSON: {}", name,
         shown(bracket == std::string::npos ? what : what.substr(bracket + 2), 200));
  }
}

int64_t whole_number(const nlohmann::json& object, const char* key, const std::string& name) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  if (found == object.end()) fail("{}: \"{}\" is missing, expected a whole number", name, key);
  const bool fits = found->is_number_unsigned() ? found->get<uint64_t>() <= uint64_t{INT64_MAX}
                                                : found->is_number_integer();
  if (!fits)
    fail("{}: \"{}\" is {}, expected a whole number", name, key,
         shown(found->dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)));
  return found->get<int64_t>();
}

}  // namespace ld
