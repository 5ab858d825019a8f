#include "weights/weight_file.h"

#include <fmt/ranges.h>

#include <charconv>
#include <sstream>

#include "core/error.h"
#include "core/json_text.h"
#include "core/shown_text.h"
#include "frame/schema.h"
#include "weights/released.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

constexpr const char* kFormat = "ld-weights";
constexpr int kFormatVersion = 1;

int version_value(const SafetensorsFile& file, const std::string& key, int newest) {
  const std::string& text = file.metadata_value(key);
  int version = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), version);
  if (error != std::errc() || stop != text.data() + text.size() || version < 1)
    fail("{}: metadata: \"{}\" is \"{}\"; expected a whole number of at least 1", file.path().string(), key,
         shown(text));
  if (version > newest)
    fail("{}: metadata: \"{}\" is {}; this program knows versions up to {}; use a newer version of it",
         file.path().string(), key, version, newest);
  return version;
}

NetworkConfig parse_network(const SafetensorsFile& file) {
  const std::string name = file.path().string() + ": metadata: network";
  try {
    NetworkConfig network =
        config_from_tree<NetworkConfig>(parse_config(file.metadata_value("network"), name));
    for (const std::string& feature : network.features) require_network_feature(feature);
    return network;
  } catch (const UsageError& error) {
    // Nobody typed this network on a command line: it is the file that is wrong. A text of parse_config
    // already names the file.
    const std::string text = error.what();
    fail("{}{}", text.rfind(name, 0) == 0 ? "" : name + ": ", shown(text, 500));
  }
}

/// Names the first feature whose line differs.
void compare_features(const SafetensorsFile& file, const NetworkConfig& network) {
  std::istringstream stored(file.metadata_value("features")), known(describe_features(network.features));
  while (true) {
    std::string theirs, ours;
    const bool has_theirs = static_cast<bool>(std::getline(stored, theirs));
    const bool has_ours = static_cast<bool>(std::getline(known, ours));
    if (!has_theirs && !has_ours) return;
    if (theirs != ours)
      fail(
          "{}: made for another feature schema: it says \"{}\" (name, channels, encoding, scale) where this "
          "program has "
          "\"{}\"; use weights trained with this version, or the version they were trained with",
          file.path().string(), has_theirs ? shown(theirs) : "nothing more",
          has_ours ? ours : "nothing more");
  }
}

fs::path existing(const fs::path& folder) {
  const fs::path file = folder / "weights.safetensors";
  return fs::is_regular_file(file) ? file : fs::path();
}

}  // namespace

Metadata make_weights_metadata(const NetworkConfig& network, const std::string& provenance) {
  return {{"format", kFormat},
          {"format_version", std::to_string(kFormatVersion)},
          {"network", config_to_yaml(network)},
          {"features", describe_features(network.features)},
          {"schema_version", std::to_string(kSchemaVersion)},
          {"provenance", provenance}};
}

WeightsHeader read_weights_header(const SafetensorsFile& file) {
  const auto format = file.metadata().find("format");
  if (format == file.metadata().end() || format->second != kFormat)
    fail(
        "{}: not a weight file of this project: its metadata says \"format\": {}; expected \"{}\"; make one "
        "with ld_train "
        "or ld_export",
        file.path().string(),
        format == file.metadata().end() ? "nothing" : fmt::format("\"{}\"", shown(format->second)), kFormat);
  version_value(file, "format_version", kFormatVersion);
  version_value(file, "schema_version", kSchemaVersion);
  WeightsHeader header;
  header.network = parse_network(file);
  compare_features(file, header.network);
  header.provenance = file.metadata_value("provenance");
  if (!header.provenance.empty())
    parse_json(header.provenance, file.path().string() + ": metadata: provenance");
  return header;
}

fs::path resolve_model(const fs::path& model) {
  std::error_code error;
  if (!fs::exists(model, error)) {
    if (fs::path file = released_model(model.string()); !file.empty()) return file;
    fail("no such model: {}; expected a file, the folder of a run, or one of the released {}", model.string(),
         fmt::join(released_models(), ", "));
  }
  if (!fs::is_directory(model)) return model;
  for (const fs::path& folder : {model, model / "checkpoints" / "best", model / "checkpoints" / "last"})
    if (fs::path file = existing(folder); !file.empty()) return file;
  fail(
      "{}: no weights in this folder; looked for weights.safetensors (a checkpoint), "
      "checkpoints/best/weights.safetensors "
      "and checkpoints/last/weights.safetensors (a run); has the training saved a checkpoint yet?",
      model.string());
}

}  // namespace ld
