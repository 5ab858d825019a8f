#include "frame/manifest.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/checksum.h"
#include "core/error.h"
#include "core/file_io.h"
#include "core/json_text.h"
#include "core/shown_text.h"
#include "frame/schema.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr int64_t kManifestVersion = 1;
constexpr const char* kFormat = "ld-dataset";
const std::vector<std::string> kSplits = {"train", "validation", "test"};

fs::path manifest_path(const fs::path& folder) {
  return folder / "manifest.json";
}

/// A member of an object with complaints that name the file and the place.
class Entry {
 public:
  Entry(const json& object, std::string where) : object_(object), where_(std::move(where)) {
    if (!object.is_object()) fail("{}: expected an object {{...}}, found {}", where_, object.type_name());
  }

  void known(const std::vector<std::string>& keys) const {
    for (const auto& item : object_.items()) {
      if (std::find(keys.begin(), keys.end(), item.key()) != keys.end()) continue;
      const std::string nearest = nearest_word(item.key(), keys);
      fail("{}: unknown key \"{}\"; {}known here: {}", where_, item.key(),
           nearest.empty() ? "" : fmt::format("did you mean \"{}\"? ", nearest), fmt::join(keys, ", "));
    }
  }
  const json* find(const std::string& key) const {
    const auto it = object_.find(key);
    return it == object_.end() ? nullptr : &*it;
  }
  const json& at(const std::string& key, const std::string& expected) const {
    const json* value = find(key);
    if (value == nullptr) fail("{}: no \"{}\"; expected {}", where_, key, expected);
    return *value;
  }
  std::string text(const std::string& key) const {
    const json& value = at(key, "a text");
    if (!value.is_string()) fail("{}: \"{}\" is {}; expected a text", where_, key, value.type_name());
    return value.get<std::string>();
  }
  std::string text_or_empty(const std::string& key) const { return find(key) == nullptr ? "" : text(key); }
  template <class Integer>
  Integer whole(const std::string& key) const {
    const json& value = at(key, "a whole number of at least 0");
    if (!value.is_number_unsigned() || value.get<uint64_t>() > uint64_t(std::numeric_limits<Integer>::max()))
      fail("{}: \"{}\" is {}; expected a whole number of at least 0", where_, key, value.dump());
    return value.get<Integer>();
  }

 private:
  const json& object_;
  std::string where_;
};

/// A frame's files must lie in the data set's folder, whatever its manifest says.
void check_name(const std::string& name, const std::string& where) {
  const fs::path path(name);
  const bool control =
      std::any_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 32; });
  const bool upwards = std::find(path.begin(), path.end(), fs::path("..")) != path.end();
  if (name.empty() || control || upwards || path.is_absolute() || !path.has_filename())
    fail("{}: the name \"{}\" is no file name inside the data set's folder; expected one like frame_000012",
         where, json(name).dump(-1, ' ', true, json::error_handler_t::replace));
}

Manifest parse_manifest(const fs::path& path) {
  const std::string file = path.string();
  const json root = parse_json(read_file(path), file);
  const Entry top(root, file);
  if (top.text("format") != kFormat)
    fail("{}: \"format\" is \"{}\"; expected \"{}\"", file, shown(top.text("format")), kFormat);
  const auto version = top.whole<int64_t>("version");
  if (version != kManifestVersion)
    fail("{}: \"version\" is {}; this program reads version {}; {}", file, version, kManifestVersion,
         version > kManifestVersion ? "use a newer version of it" : "see docs/data_format.md");
  top.known({"format", "version", "schema", "recipe", "seed", "frames"});

  if (const json* schema_json = top.find("schema")) {
    const Entry schema(*schema_json, file + ": schema");
    schema.known({"version", "features"});
    if (schema.whole<int64_t>("version") > kSchemaVersion)
      fail("{}: made with feature schema {}; this program knows schemas up to {}; use a newer version of it",
           file, schema.whole<int64_t>("version"), kSchemaVersion);
    if (const json* features = schema.find("features")) {
      if (!features->is_array())
        fail("{}: schema: \"features\" is {}; expected a list of texts", file, features->type_name());
      for (const json& feature : *features)
        if (!feature.is_string())
          fail("{}: schema: a feature is {}; expected a text", file, feature.type_name());
    }
  }

  Manifest manifest;
  manifest.recipe = top.text_or_empty("recipe");
  if (top.find("seed") != nullptr) manifest.seed = top.whole<uint64_t>("seed");
  const json& frames = top.at("frames", "a list of {\"name\": ..., \"split\": ...}");
  if (!frames.is_array()) fail("{}: \"frames\" is {}; expected a list", file, frames.type_name());
  std::set<std::string> names;
  for (size_t i = 0; i < frames.size(); ++i) {
    const std::string where = fmt::format("{}: frames[{}]", file, i);
    const Entry entry(frames[i], where);
    entry.known({"name", "split", "index", "sequence", "position", "checksum", "reference_checksum"});
    ManifestFrame frame;
    frame.name = entry.text("name");
    frame.split = entry.text("split");
    if (entry.find("index") != nullptr) frame.index = entry.whole<int64_t>("index");
    if (entry.find("sequence") != nullptr) frame.sequence = entry.whole<int64_t>("sequence");
    if (entry.find("position") != nullptr) frame.position = entry.whole<int64_t>("position");
    frame.checksum = entry.text_or_empty("checksum");
    frame.reference_checksum = entry.text_or_empty("reference_checksum");
    check_entry(frame, where);
    if (!names.insert(frame.name).second)
      fail("{}: the name \"{}\" stands twice; remove one", where, frame.name);
    manifest.frames.push_back(std::move(frame));
  }
  std::sort(manifest.frames.begin(), manifest.frames.end(),
            [](const ManifestFrame& a, const ManifestFrame& b) { return a.name < b.name; });
  return manifest;
}

std::string manifest_text(const fs::path& path, const Manifest& manifest) {
  nlohmann::ordered_json root;
  root["format"] = kFormat;
  root["version"] = kManifestVersion;
  root["schema"] = {{"version", kSchemaVersion}, {"features", mh20_feature_names()}};
  root["recipe"] = manifest.recipe;
  root["seed"] = manifest.seed;
  root["frames"] = nlohmann::ordered_json::array();
  for (const ManifestFrame& frame : manifest.frames) {
    nlohmann::ordered_json entry = {{"name", frame.name}, {"split", frame.split}, {"index", frame.index}};
    if (frame.sequence) entry["sequence"] = *frame.sequence;
    if (frame.position) entry["position"] = *frame.position;
    if (!frame.checksum.empty()) entry["checksum"] = frame.checksum;
    if (!frame.reference_checksum.empty()) entry["reference_checksum"] = frame.reference_checksum;
    root["frames"].push_back(std::move(entry));
  }
  try {
    return root.dump(1) + "\n";
  } catch (const json::exception& error) {
    fail("cannot write {}: the recipe or a name is not UTF-8 ({})", path.string(), error.what());
  }
}

void verify_file(const fs::path& path, const std::string& expected) {
  std::error_code error;  // a name that no file system takes is a file that is not there
  if (!fs::is_regular_file(path, error))
    fail("{}: listed in the manifest, but there is no such file; render it again or take it off the list",
         path.string());
  if (expected.empty()) return;
  const std::string found = file_checksum(path);
  if (found != expected)
    fail("{}: checksum {}; the manifest says {}; the file was changed or damaged, copy or render it again",
         path.string(), found, expected);
}

}  // namespace

void check_entry(const ManifestFrame& frame, const std::string& where) {
  check_name(frame.name, where);
  if (std::find(kSplits.begin(), kSplits.end(), frame.split) == kSplits.end())
    fail("{}: the split of \"{}\" is \"{}\"; expected one of {}", where, frame.name, frame.split,
         fmt::join(kSplits, ", "));
}

fs::path frame_path(const fs::path& folder, const std::string& name) {
  return folder / (name + ".exr");
}
fs::path reference_path(const fs::path& folder, const std::string& name) {
  return folder / (name + ".reference.exr");
}

Manifest read_manifest(const fs::path& folder) {
  const fs::path path = manifest_path(folder);
  if (!fs::is_directory(folder))
    fail("{}: no such folder; expected a data set, a folder with manifest.json", folder.string());
  if (!fs::exists(path))
    fail(
        "{}: no manifest.json, so it is no data set; make one with ld_render, or write it by hand "
        "(docs/data_format.md)",
        folder.string());
  return parse_manifest(path);
}

void add_to_manifest(const fs::path& folder, const Manifest& addition) {
  const fs::path path = manifest_path(folder);
  for (const ManifestFrame& frame : addition.frames) check_entry(frame, "cannot add to " + path.string());
  make_folder(folder);
  const FileLock lock(folder / ".manifest.lock");
  Manifest merged = addition;
  merged.frames.clear();
  std::map<std::string, ManifestFrame> by_name;
  if (fs::exists(path)) {
    const Manifest existing = parse_manifest(path);
    if (existing.recipe != addition.recipe || existing.seed != addition.seed)
      fail("{}: holds frames of another {}; choose another folder, or remove this one to start afresh",
           folder.string(),
           existing.seed == addition.seed
               ? "recipe"
               : fmt::format("seed ({} there, {} here)", existing.seed, addition.seed));
    for (const ManifestFrame& frame : existing.frames) by_name[frame.name] = frame;
  }
  for (const ManifestFrame& frame : addition.frames) by_name[frame.name] = frame;
  for (auto& [name, frame] : by_name) merged.frames.push_back(std::move(frame));
  write_file_atomically(path, manifest_text(path, merged));
}

std::vector<ManifestFrame> frames_of_split(const fs::path& folder, const std::string& split) {
  std::vector<ManifestFrame> frames;
  std::map<std::string, int> counts;
  for (ManifestFrame& frame : read_manifest(folder).frames) {
    ++counts[frame.split];
    if (frame.split == split) frames.push_back(std::move(frame));
  }
  if (!frames.empty()) return frames;
  std::string found;
  for (const auto& [name, count] : counts)
    found += fmt::format("{}{} ({})", found.empty() ? "" : ", ", name, count);
  if (found.empty()) fail("{}: no frames at all; render some, or add them with ld_import", folder.string());
  fail_usage(
      "{}: no frames of the split '{}'; it has {}; render more frames or change their splits in "
      "manifest.json",
      folder.string(), split, found);
}

void verify_frame(const fs::path& folder, const ManifestFrame& frame) {
  verify_file(frame_path(folder, frame.name), frame.checksum);
  if (frame.has_reference) verify_file(reference_path(folder, frame.name), frame.reference_checksum);
}

}  // namespace ld
