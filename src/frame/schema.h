// The per-sample features of [MH20] (Munkberg and Hasselgren, "Neural Denoising with Layer Embeddings", EGSR
// 2020, section 3), 20 floats in all, and those that frames may hold besides: one table that the renderer,
// the files, the filters, the networks and the weights share.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "frame/half_range.h"

namespace ld {

/// Version of this table; stored in frames, data sets and weights.
constexpr int kSchemaVersion = 1;

/// How a network sees a feature. The files hold it in the units of the table in schema.cpp.
enum class Encoding {
  tone_map,  // eq. 7: Gamma(log(1 + x)), Gamma the sRGB transfer function
  identity,
  depth,   // d / (d + the frame's median finite depth); 1 where the ray escaped
  squash,  // x / (|x| + scale): bounded by 1, odd, so that it commutes with flips and quarter turns
  place,   // squash with the frame's median finite depth as scale
  none     // not at all: it is for filters
};

/// What a flip or a rotation of the picture does to a feature besides moving its pixels.
enum class Vector {
  none,    // a scalar or a colour: nothing
  y_up,    // x and y turn with the picture, +y points up (view-space normal, lens position)
  y_down,  // x and y turn with the picture, +y points down (motion vector, flow)
};

struct Feature {
  std::string name;
  int offset;  // first of its channels among all kSampleChannels
  int channels;
  std::array<const char*, 3> exr_channels;  // the first `channels` of them count
  Encoding encoding;
  float scale;  // of Encoding::squash, in the feature's unit
  Vector vector;
};

/// Channels of [MH20] and flow, which every frame in memory has room for; and all that a frame may hold.
constexpr int kSampleChannels = 22, kAllChannels = 39;
constexpr int kRadianceOffset = 0;
constexpr int kNormalOffset = 3;
constexpr int kDepthOffset = 6;
constexpr int kFlowOffset = 20;
constexpr int kIdOffset = 22;
constexpr int kFlowDepthOffset = 23;
constexpr int kDirectOffset = 24;
constexpr int kIndirectOffset = 27;
constexpr int kEmissionOffset = 30;
constexpr int kHalfRadianceOffset = 33;
constexpr int kPositionOffset = 36;
/// Depth of a ray that escaped: half's largest finite number.
constexpr float kEscapedDepth = kHalfMax;
/// Flow in x and y of what the previous frame did not see, after a cut: it leads out of every picture.
constexpr float kNoFlow = kHalfMax;
/// Ids are whole numbers from 0 to this, which floats hold exactly.
constexpr float kMostId = 1 << 24;

/// All features in the order of their offsets: radiance, normal, depth, albedo, specular, roughness, motion,
/// coc, lens, time, which are the 20 channels of [MH20]; then flow, which sequences have; then what classical
/// filters read: id, flow_depth, direct, indirect, emission; then what super-resolution reads: half_radiance
/// and position (frame/derived_features.h).
const std::vector<Feature>& feature_schema();

/// Throws UsageError with the nearest name and the list of names when there is no such feature.
const Feature& find_feature(const std::string& name);

/// All of them.
std::vector<std::string> feature_names();

/// Those of [MH20]: what a frame holds and a network reads unless told otherwise.
std::vector<std::string> mh20_feature_names();

/// Those of [MH20] and flow: what `network.features: auto` looks for.
std::vector<std::string> auto_feature_names();

/// Throws UsageError for a feature that no network can read, and as find_feature().
void require_network_feature(const std::string& name);

/// Channels of a sample that a frame in memory needs for these features: kSampleChannels, or kAllChannels
/// where one of them lies beyond.
int frame_channels(const std::vector<std::string>& names);

/// Channels that the named features have together.
int channel_count(const std::vector<std::string>& names);

/// First channel of the feature `wanted` among those of the named ones; -1 when it is not one of them.
int first_channel(const std::vector<std::string>& names, const std::string& wanted);

/// One line a feature: name, channels, encoding, scale. Two weight files fit the same frames when these
/// agree.
std::string describe_features(const std::vector<std::string>& names);

}  // namespace ld
