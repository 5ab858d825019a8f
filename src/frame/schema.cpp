#include "frame/schema.h"

#include <fmt/ranges.h>

#include "core/error.h"

namespace ld {
namespace {

const char* encoding_name(Encoding encoding) {
  switch (encoding) {
    case Encoding::tone_map:
      return "tone_map";
    case Encoding::identity:
      return "identity";
    case Encoding::depth:
      return "depth";
    case Encoding::squash:
      return "squash";
    case Encoding::place:
      return "place";
    case Encoding::none:
      return "none";
  }
  return "";
}

}  // namespace

const std::vector<Feature>& feature_schema() {
  // Unit and frame of each, as the files hold it:
  static const std::vector<Feature> schema = {
      // linear, scene-referred, >= 0
      {"radiance", kRadianceOffset, 3, {"R", "G", "B"}, Encoding::tone_map, 0, Vector::none},
      // view space, right-handed: +x right, +y up, +z towards the camera; zero where the ray escaped
      {"normal", kNormalOffset, 3, {"N.X", "N.Y", "N.Z"}, Encoding::identity, 0, Vector::y_up},
      // scene units along the view axis; kEscapedDepth where the ray escaped
      {"depth", kDepthOffset, 1, {"Z"}, Encoding::depth, 0, Vector::none},
      // diffuse colour of the first hit
      {"albedo", 7, 3, {"albedo.R", "albedo.G", "albedo.B"}, Encoding::identity, 0, Vector::none},
      // specular colour of the first hit
      {"specular", 10, 3, {"specular.R", "specular.G", "specular.B"}, Encoding::identity, 0, Vector::none},
      // of the first hit, 0 a mirror, 1 diffuse
      {"roughness", 13, 1, {"roughness"}, Encoding::identity, 0, Vector::none},
      // pixels over the shutter interval, +x right, +y down; 16 pixels are half-way to the bound
      {"motion", 14, 2, {"motion.X", "motion.Y"}, Encoding::squash, 16, Vector::y_down},
      // signed radius in pixels, positive behind the focal plane; 4 pixels are half-way to the bound
      {"coc", 16, 1, {"coc"}, Encoding::squash, 4, Vector::none},
      // unit disk, +x right, +y up
      {"lens", 17, 2, {"lens.X", "lens.Y"}, Encoding::identity, 0, Vector::y_up},
      // 0 at shutter open, 1 at close
      {"time", 19, 1, {"time"}, Encoding::identity, 0, Vector::none},
      // not in [MH20]: pixels from where the sample hit to where the picture saw that point of the surface at
      // the shutter opening of the previous frame, +x right, +y down; squashed like motion
      {"flow", kFlowOffset, 2, {"flow.X", "flow.Y"}, Encoding::squash, 16, Vector::y_down},
      // For filters. Which object, which has one material, the sample shows: a whole number, the same in all
      // frames of a sequence; 0 where the ray escaped
      {"id", kIdOffset, 1, {"id"}, Encoding::none, 0, Vector::none},
      // scene units: the depth at the end of flow in the previous frame's view less that at its beginning
      {"flow_depth", kFlowDepthOffset, 1, {"flow.Z"}, Encoding::none, 0, Vector::none},
      // Parts of radiance, their sum: of paths of two segments (camera, surface, light), of longer ones, and
      // of one segment, which is light that the camera sees itself
      {"direct", kDirectOffset, 3, {"direct.R", "direct.G", "direct.B"}, Encoding::tone_map, 0, Vector::none},
      {"indirect",
       kIndirectOffset,
       3,
       {"indirect.R", "indirect.G", "indirect.B"},
       Encoding::tone_map,
       0,
       Vector::none},
      {"emission",
       kEmissionOffset,
       3,
       {"emission.R", "emission.G", "emission.B"},
       Encoding::tone_map,
       0,
       Vector::none},
      // For super-resolution. Radiance of the same view at half the width and height (rounded up), of random
      // numbers of its own: all pixels of 2x2 hold the same
      {"half_radiance",
       kHalfRadianceOffset,
       3,
       {"half_radiance.R", "half_radiance.G", "half_radiance.B"},
       Encoding::tone_map,
       0,
       Vector::none},
      // view space as normal's, scene units: where the first hit is, from the camera
      {"position", kPositionOffset, 3, {"P.X", "P.Y", "P.Z"}, Encoding::place, 0, Vector::y_up},
  };
  return schema;
}

const Feature& find_feature(const std::string& name) {
  for (const Feature& feature : feature_schema())
    if (feature.name == name) return feature;
  const std::string nearest = nearest_word(name, feature_names());
  fail_usage("unknown feature '{}'; {}the features are {}", name,
             nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest),
             fmt::join(feature_names(), ", "));
}

std::vector<std::string> feature_names() {
  std::vector<std::string> names;
  for (const Feature& feature : feature_schema()) names.push_back(feature.name);
  return names;
}

std::vector<std::string> mh20_feature_names() {
  std::vector<std::string> names = auto_feature_names();
  names.pop_back();  // flow
  return names;
}

std::vector<std::string> auto_feature_names() {
  std::vector<std::string> names;
  for (const Feature& feature : feature_schema())
    if (feature.offset < kSampleChannels) names.push_back(feature.name);
  return names;
}

void require_network_feature(const std::string& name) {
  if (find_feature(name).encoding == Encoding::none)
    fail_usage("the feature '{}' is for filters; expected another one in network.features", name);
}

int frame_channels(const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (find_feature(name).offset >= kSampleChannels) return kAllChannels;
  return kSampleChannels;
}

int channel_count(const std::vector<std::string>& names) {
  int count = 0;
  for (const std::string& name : names) count += find_feature(name).channels;
  return count;
}

int first_channel(const std::vector<std::string>& names, const std::string& wanted) {
  int channel = 0;
  for (const std::string& name : names) {
    if (name == wanted) return channel;
    channel += find_feature(name).channels;
  }
  return -1;
}

std::string describe_features(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    const Feature& feature = find_feature(name);
    text += fmt::format("{} {} {}", name, feature.channels, encoding_name(feature.encoding));
    if (feature.encoding == Encoding::squash) text += fmt::format(" {}", feature.scale);
    text += "\n";
  }
  return text;
}

}  // namespace ld
