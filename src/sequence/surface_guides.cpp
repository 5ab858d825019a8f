#include "sequence/surface_guides.h"

#include <algorithm>
#include <cmath>
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

/// Whether pixel (x, y) of the previous frame shows what a pixel shows now.
class SameSurface {
 public:
  SameSurface(const SurfaceGuides& now, const SurfaceGuides& before, int x, int y)
      : before_(before), surface_(now.surface[now.index(x, y)]) {
    const float slope = depth_slope(now.depth.data(), now.width, now.height, x, y, kEscapedDepth);
    tolerance_ = depth_tolerance(slope, now.depth_scale);
    expected_depth_ = surface_.depth + now.flow_z[now.index(x, y)];
  }
  bool operator()(int x, int y) const {
    const Surface& past = before_.surface[before_.index(x, y)];
    return past.depth < kEscapedDepth && is_same_surface(surface_, expected_depth_, tolerance_, past);
  }

 private:
  const SurfaceGuides& before_;
  const Surface& surface_;
  float tolerance_, expected_depth_;
};

Reprojection reproject_pixel(const SurfaceGuides& now, const SurfaceGuides& before, int x, int y) {
  const SameSurface same(now, before, x, y);
  const float past_x = static_cast<float>(x) + now.flow_x[now.index(x, y)],
              past_y = static_cast<float>(y) + now.flow_y[now.index(x, y)];
  Reprojection found;
  found.taps = bilinear_taps(past_x, past_y, now.width, now.height);
  float sum = 0, heaviest = 0;
  for (BilinearTap& tap : found.taps) {
    if (tap.weight > 0 && !same(tap.x, tap.y)) tap.weight = 0;
    sum += tap.weight;
    if (tap.weight > heaviest) {
      heaviest = tap.weight;
      found.seen_at = static_cast<int64_t>(before.index(tap.x, tap.y));
    }
  }
  found.valid = sum >= kReprojectionWeight;
  for (BilinearTap& tap : found.taps) tap.weight = found.valid ? tap.weight / sum : 0;
  // Not far outside, and no NaN: a whole number.
  if (found.seen_at >= 0 || !(std::abs(past_x) < 1e6F && std::abs(past_y) < 1e6F)) return found;
  const auto middle_x = static_cast<int>(std::lround(past_x)),
             middle_y = static_cast<int>(std::lround(past_y));
  for (int j = std::max(middle_y - 1, 0); j <= std::min(middle_y + 1, now.height - 1); ++j)
    for (int i = std::max(middle_x - 1, 0); i <= std::min(middle_x + 1, now.width - 1); ++i)
      if (found.seen_at < 0 && same(i, j)) found.seen_at = static_cast<int64_t>(before.index(i, j));
  return found;
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
      if (now.surface[p].depth < kEscapedDepth) result[p] = reproject_pixel(now, before, x, y);
    }
  return result;
}

}  // namespace ld
