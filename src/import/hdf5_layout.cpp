#include "import/hdf5_layout.h"

#include <algorithm>
#include <cmath>

namespace ld {
namespace {

constexpr float kFarthestRatio = 1.0F - 1.0F / 2048;  // half floats know nothing between it and 1

template <class Change>
void for_each_valid(Frame& frame, int channel, const Change& change) {
  for (int s = 0; s < frame.spp; ++s) {
    float* plane = frame.plane(s, channel);
    for (size_t p = 0; p < frame.plane_size(); ++p)
      if (frame.valid_plane(s)[p] != 0) plane[p] = change(plane[p]);
  }
}

void scale_motion(Frame& frame, float x, float y) {
  if (!frame.holds("motion")) return;
  const int offset = find_feature("motion").offset;
  for_each_valid(frame, offset, [&](float value) { return value * x + 0.0F; });
  for_each_valid(frame, offset + 1, [&](float value) { return value * y + 0.0F; });
}

/// 0 where the ray escaped.
float squared_normal(const Frame& frame, int sample, size_t pixel) {
  float sum = 0;
  for (int c = 0; c < 3; ++c) {
    const float value = frame.plane(sample, kNormalOffset + c)[pixel];
    sum += value * value;
  }
  return sum;
}

}  // namespace

const std::vector<Hdf5Group>& hdf5_layout() {
  static const std::vector<Hdf5Group> layout = {
      {"color", 3, {"radiance", nullptr}},  {"normals_depth", 4, {"normal", "depth"}},
      {"albedo", 3, {"albedo", nullptr}},   {"specular", 4, {"specular", "roughness"}},
      {"motionvecs", 3, {"motion", "coc"}}, {"uvt", 3, {"lens", "time"}},
  };
  return layout;
}

const Hdf5Group& hdf5_scene_depth() {
  static const Hdf5Group depth = {"depth", 1, {"depth", nullptr}};
  return depth;
}

const std::vector<Hdf5Group>& hdf5_filter_layout() {
  static const std::vector<Hdf5Group> layout = {
      {"flow", 2, {"flow", nullptr}},
      {"id", 1, {"id", nullptr}, true},
      {"flow_depth", 1, {"flow_depth", nullptr}},
      {"direct", 3, {"direct", nullptr}},
      {"indirect", 3, {"indirect", nullptr}},
      {"emission", 3, {"emission", nullptr}},
  };
  return layout;
}

void frame_from_hdf5_units(Frame& frame, Hdf5Depth depth, float depth_scale) {
  scale_motion(frame, 0.5F * static_cast<float>(frame.width), -0.5F * static_cast<float>(frame.height));
  if (!frame.holds("depth") || depth == Hdf5Depth::scene) return;
  if (depth == Hdf5Depth::ratio) {
    for_each_valid(frame, kDepthOffset, [&](float z) {
      return z >= 1 ? kEscapedDepth : depth_scale * std::max(z, 0.0F) / (1 - z);
    });
    return;
  }
  for (int s = 0; s < frame.spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p)
      if (frame.valid_plane(s)[p] != 0 && !(squared_normal(frame, s, p) > 0))
        frame.plane(s, kDepthOffset)[p] = kEscapedDepth;
}

void frame_to_hdf5_units(Frame& frame) {
  scale_motion(frame, 2 / static_cast<float>(frame.width), -2 / static_cast<float>(frame.height));
  if (!frame.holds("depth")) return;
  const float scale = frame.info.depth_scale;
  for_each_valid(frame, kDepthOffset, [&](float z) {
    return z >= kEscapedDepth ? 1.0F : std::min(z / (z + scale), kFarthestRatio);
  });
}

}  // namespace ld
