#include "import/mapping.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.h"
#include "frame/schema.h"
#include "import/light_parts.h"
#include "import/presets.h"

namespace ld {
namespace {

bool names_samples(const std::string& pattern) {
  return pattern.find("{sample}") != std::string::npos;
}

/// Scale and offset for each component.
void spread(std::vector<double>& values, size_t components, const std::string& what) {
  if (values.size() == 1) values.resize(components, values[0]);
  if (values.size() != components)
    fail_usage("mapping: {} has {} numbers; expected one for all components or {}, one for each", what,
               values.size(), components);
}

void check_feature(FeatureMapping& feature, const ImportMapping& mapping, const std::string& key) {
  if (feature.channels.empty()) return;
  if (feature.kind.empty()) feature.kind = feature.feature == "depth" ? "planar" : "roughness";
  if (feature.channels.size() != feature.components())
    fail_usage("mapping: {}.channels names {} channels; expected {}, or none to leave it out", key,
               feature.channels.size(), feature.components());
  spread(feature.scale, feature.components(), key + ".scale");
  spread(feature.offset, feature.components(), key + ".offset");
  const std::string& part = feature.part.empty() ? mapping.part : feature.part;
  const auto counted = std::count_if(feature.channels.begin(), feature.channels.end(), names_samples);
  if (counted > 0 && names_samples(part))
    fail_usage("mapping: {} has {{sample}} in its channels and in its part; expected it in one of them", key);
  if (counted > 0 && counted != static_cast<std::ptrdiff_t>(feature.channels.size()))
    fail_usage("mapping: {}.channels has {{sample}} in some patterns only; expected it in all or none", key);
  if (!feature.per_sample && (counted > 0 || names_samples(part)))
    fail_usage("mapping: {} is not per_sample, but its patterns have {{sample}}; expected one of the two",
               key);
}

}  // namespace

size_t FeatureMapping::components() const {
  if (feature == "alpha") return 1;
  return is_position() ? 3 : static_cast<size_t>(find_feature(feature).channels);
}

bool FeatureMapping::is_position() const {
  return kind.find("position") != std::string::npos;
}

ImportMapping::ImportMapping() {
  alpha.feature = "alpha";
  for (const std::string& name : feature_names()) {
    features.emplace_back().feature = name;
    features.emplace_back().feature = name;
  }
}

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const Preset& preset : presets()) names.push_back(preset.name);
  return names;
}

const std::string& preset_text(const std::string& name) {
  for (const Preset& preset : presets())
    if (preset.name == name) return preset.text;
  const std::string nearest = nearest_word(name, preset_names());
  fail_usage("unknown preset '{}'; {}the presets are {}; --mapping takes a file of your own", name,
             nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest),
             fmt::join(preset_names(), ", "));
}

ImportMapping read_mapping(const std::string& name, const std::filesystem::path& path,
                           const std::vector<std::string>& assignments) {
  ConfigNode root = path.empty() ? parse_config(preset_text(name), "preset " + name) : read_config(path);
  for (const std::string& assignment : assignments) apply_override(root, assignment);
  auto mapping = config_from_tree<ImportMapping>(root);
  check_feature(mapping.alpha, mapping, "alpha");
  for (size_t i = 0; i < mapping.features.size(); ++i)
    check_feature(mapping.features[i], mapping, mapping.features[i].feature + (i % 2 == 0 ? "" : "_2"));
  for (const std::string& part : mapping.parts) parse_light_part(part);
  if (mapping.features[0].channels.empty())
    fail_usage("mapping: no radiance.channels; expected the patterns of its red, green and blue channel");
  return mapping;
}

}  // namespace ld
