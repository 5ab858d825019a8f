#include "sequence/surface_guides.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ld {
namespace {

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
    const SeenSurface& past = before_.surface[before_.index(x, y)];
    return past.depth < kEscapedDepth && is_same_surface(surface_, expected_depth_, tolerance_, past);
  }

 private:
  const SurfaceGuides& before_;
  const SeenSurface& surface_;
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

int representative_sample(const Frame& frame, size_t pixel) {
  if (frame.spp == 1) return frame.valid[pixel] != 0 ? 0 : -1;
  const bool has_depth = frame.holds("depth");
  std::array<std::pair<float, int>, 64> few;
  std::vector<std::pair<float, int>> many;
  std::pair<float, int>* found = few.data();
  if (frame.spp > static_cast<int>(few.size())) {
    many.resize(static_cast<size_t>(frame.spp));
    found = many.data();
  }
  int count = 0;
  for (int s = 0; s < frame.spp; ++s)
    if (frame.valid_plane(s)[pixel] != 0)
      found[count++] = {has_depth ? frame.plane(s, kDepthOffset)[pixel] : 0.0F, s};
  if (count == 0) return -1;
  std::nth_element(found, found + (count - 1) / 2, found + count);
  return found[(count - 1) / 2].second;
}

std::optional<std::array<float, 9>> view_to_world(const FrameInfo& info) {
  if (!info.world_to_camera) return std::nullopt;
  const Matrix4 m = camera_to_world(*info.world_to_camera);
  std::array<float, 9> turn{};
  for (size_t column = 0; column < 3; ++column) {
    const float length =
        std::sqrt(m[column] * m[column] + m[4 + column] * m[4 + column] + m[8 + column] * m[8 + column]);
    if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
    for (size_t row = 0; row < 3; ++row) turn[3 * row + column] = m[4 * row + column] / length;
  }
  return turn;
}

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
  const auto turn = view_to_world(frame.info);
  for (size_t p = 0; p < count; ++p) {
    SeenSurface& surface = guides.surface[p];
    surface.depth = kEscapedDepth;
    const int s = representative_sample(frame, p);
    if (s < 0) continue;
    surface.depth = depth >= 0 ? frame.plane(s, depth)[p] : 1.0F;
    guides.depth[p] = surface.depth;
    if (normal >= 0) {
      const std::array<float, 3> n = {frame.plane(s, normal)[p], frame.plane(s, normal + 1)[p],
                                      frame.plane(s, normal + 2)[p]};
      const auto along = [&](size_t row) {
        if (!turn) return n[row];
        return (*turn)[3 * row] * n[0] + (*turn)[3 * row + 1] * n[1] + (*turn)[3 * row + 2] * n[2];
      };
      surface.nx = along(0);
      surface.ny = along(1);
      surface.nz = along(2);
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
