#include "sequence/surface_guides.h"

#include <algorithm>
#include <utility>

namespace ld {
namespace {

/// The sample that stands for a pixel; -1 where none is valid.
int representative_sample(const Frame& frame, bool has_depth, size_t pixel,
                          std::vector<std::pair<float, int>>& depths) {
  depths.clear();
  for (int s = 0; s < frame.spp; ++s)
    if (frame.valid_plane(s)[pixel] != 0)
      depths.emplace_back(has_depth ? frame.plane(s, kDepthOffset)[pixel] : 1.0F, s);
  if (depths.empty()) return -1;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>((depths.size() - 1) / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return middle->second;
}

/// First channel of a feature that the frame holds; -1.
int held_channel(const Frame& frame, const std::string& feature) {
  return frame.holds(feature) ? find_feature(feature).offset : -1;
}

}  // namespace

SurfaceGuides surface_guides(const Frame& frame) {
  SurfaceGuides guides;
  guides.width = frame.width;
  guides.height = frame.height;
  guides.depth_scale = median_depth(frame);
  guides.has_flow = frame.holds("flow");
  const size_t count = frame.plane_size();
  guides.surface.resize(count);
  guides.depth.assign(count, kEscapedDepth);
  for (std::vector<float>* plane : {&guides.flow_x, &guides.flow_y, &guides.flow_z}) plane->assign(count, 0);
  const int depth = held_channel(frame, "depth"), normal = held_channel(frame, "normal"),
            flow = held_channel(frame, "flow"), flow_depth = held_channel(frame, "flow_depth"),
            id = held_channel(frame, "id");
  std::vector<std::pair<float, int>> depths;
  for (size_t p = 0; p < count; ++p) {
    Surface& surface = guides.surface[p];
    surface.depth = kEscapedDepth;
    const int s = representative_sample(frame, depth >= 0, p, depths);
    if (s < 0) continue;
    surface.depth = depth >= 0 ? frame.plane(s, depth)[p] : 1.0F;
    guides.depth[p] = surface.depth;
    if (normal >= 0) {
      surface.nx = frame.plane(s, normal)[p];
      surface.ny = frame.plane(s, normal + 1)[p];
      surface.nz = frame.plane(s, normal + 2)[p];
    }
    if (id >= 0) surface.id = frame.plane(s, id)[p];
    if (flow_depth >= 0) guides.flow_z[p] = frame.plane(s, flow_depth)[p];
    if (flow >= 0) {
      guides.flow_x[p] = frame.plane(s, flow)[p];
      guides.flow_y[p] = frame.plane(s, flow + 1)[p];
    }
  }
  return guides;
}

std::vector<Reprojection> reproject(const SurfaceGuides& now, const SurfaceGuides& before) {
  std::vector<Reprojection> result(now.surface.size());
  if (!now.has_flow || now.width != before.width || now.height != before.height) return result;
  for (int y = 0; y < now.height; ++y)
    for (int x = 0; x < now.width; ++x) {
      const size_t p = now.index(x, y);
      const Surface& surface = now.surface[p];
      if (!(surface.depth < kEscapedDepth)) continue;
      const float slope = depth_slope(now.depth.data(), now.width, now.height, x, y, kEscapedDepth);
      const float tolerance = depth_tolerance(slope, now.depth_scale),
                  expected = surface.depth + now.flow_z[p];
      Reprojection& found = result[p];
      found.taps = bilinear_taps(static_cast<float>(x) + now.flow_x[p], static_cast<float>(y) + now.flow_y[p],
                                 now.width, now.height);
      float sum = 0;
      for (BilinearTap& tap : found.taps) {
        const Surface& past = before.surface[before.index(tap.x, tap.y)];
        if (!(past.depth < kEscapedDepth) || !is_same_surface(surface, expected, tolerance, past))
          tap.weight = 0;
        sum += tap.weight;
      }
      found.valid = sum >= kReprojectionWeight;
      for (BilinearTap& tap : found.taps) tap.weight = found.valid ? tap.weight / sum : 0;
    }
  return result;
}

}  // namespace ld
