// Where another renderer keeps the features of a sample, and in which conventions: what the YAML files in
// data/import say (docs/import.md describes every key).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/config_visitor.h"
#include "frame/schema.h"

namespace ld {

/// One feature. Its value is scale * channel + offset, component by component, then what `space`, `kind` and
/// `unit` say.
struct FeatureMapping {
  std::string feature;                   // of the schema, or "alpha"
  std::vector<std::string> channels;     // a pattern for each component; empty: not there
  std::string part;                      // pattern of the part's name; empty: `part` of the mapping
  std::vector<double> scale = {1};       // one number for all components or one each
  std::vector<double> offset = {0};      // likewise; value = scale * channel + offset
  bool per_sample = true;                // false: one plane for all samples, found in the first file
  std::string space = "view";            // that normals stand in
  bool face_camera = false;              // true: normals that look away are turned round
  std::string kind;                      // what the channels hold; empty: planar, or roughness
  bool inverse = false;                  // true: the channel holds 1 / depth
  double near = 0;                       // distances begin at this depth
  double escaped_above = kEscapedDepth;  // channel values from here on are rays that escaped
  std::vector<double> escaped_at;        // channel values that are rays that escaped, too
  double maximum = kHalfMax;             // colours above it are set to it
  std::string unit = "pixels";           // of the vectors

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("channels", channels);
    v.field("part", part);
    v.field("scale", scale);
    v.field("offset", offset);
    v.field("per_sample", per_sample);
    if (feature == "normal") {
      v.field("space", space, {"view", "view_z_forward", "world"});
      v.field("face_camera", face_camera);
    }
    if (feature == "depth") {
      v.field("kind", kind,
              {"planar", "distance", "view_position", "view_position_z_forward", "world_position"});
      v.field("inverse", inverse);
      v.field("near", near, at_least(0));
      v.field("escaped_above", escaped_above);
      v.field("escaped_at", escaped_at);
    }
    if (feature == "roughness") v.field("kind", kind, {"roughness", "alpha"});
    if (feature == "albedo" || feature == "specular") v.field("maximum", maximum, at_least(0));
    if (feature == "motion" || feature == "flow") v.field("unit", unit, {"pixels", "ndc", "picture"});
  }

  /// Channels that the patterns must name: 3 for depth that is taken from positions.
  size_t components() const;
  bool is_position() const;
};

struct ImportMapping {
  ImportMapping();

  std::string about;        // a text for people
  std::string layer = "*";  // what {layer} in patterns stands for
  std::string part = "*";   // pattern of the names of parts that are looked at
  std::string view;         // which of a file's views, such as left and right; empty: the hero
  FeatureMapping alpha;     // as a feature, with one channel
  /// All features of the schema, each with its second choice behind it: taken where a file lacks the first.
  std::vector<FeatureMapping> features;
  std::vector<std::string> parts;  // of the light, "NAME = LAYER * LAYER + LAYER" (light_parts.h)

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("about", about);
    v.field("layer", layer);
    v.field("part", part);
    v.field("view", view);
    v.section("alpha", alpha);
    for (size_t i = 0; i < features.size(); ++i)
      v.section(features[i].feature + (i % 2 == 0 ? "" : "_2"), features[i]);
    v.field("parts", parts);
  }
};

std::vector<std::string> preset_names();

/// The YAML text of a preset of data/import, which the program carries with it. Throws UsageError with the
/// nearest name for another.
const std::string& preset_text(const std::string& name);

/// The preset `name`, or the YAML file `path` where that is not empty, with "key.sub=value" assignments on
/// top. Throws UsageError for unknown keys and for mappings that contradict themselves.
ImportMapping read_mapping(const std::string& name, const std::filesystem::path& path,
                           const std::vector<std::string>& assignments);

}  // namespace ld
