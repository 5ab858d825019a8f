#include "filters/frame_guides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "frame/picture_place.h"
#include "runtime/parallel.h"
#include "sequence/surface_guides.h"

namespace ld {
namespace {

using Vector3 = std::array<float, 3>;

/// Where the ray through a pixel's middle crosses the plane at depth 1 of view space: x = left + right_step
/// (column), y = top + down_step (row).
struct RayGrid {
  float left = 0, right_step = 0, top = 0, down_step = 0;
};

/// From the matrices, for cameras whose picture is a rectangle of that plane.
std::optional<RayGrid> ray_grid(const Frame& frame) {
  const FrameInfo& info = frame.info;
  if (!info.world_to_camera || !info.world_to_ndc) return std::nullopt;
  // NDC = (p . column) / (p . last column): along the camera's axes, offset and slope of ndc(x / depth).
  const Matrix4 to_world = camera_to_world(*info.world_to_camera);
  const Matrix4& ndc = *info.world_to_ndc;
  const auto along = [&](size_t axis, size_t column) {  // of an axis of view space
    double sum = 0;
    for (size_t i = 0; i < 3; ++i) sum += double(to_world[4 * i + axis]) * ndc[4 * i + column];
    return sum;
  };
  const double depth = -along(2, 3);  // +z is towards the viewer
  const double slope_x = along(0, 0) / depth, slope_y = along(1, 1) / depth;
  const double offset_x = -along(2, 0) / depth, offset_y = -along(2, 1) / depth;
  const Windows& windows = info.windows;
  const bool cut_out = windows.has_display();
  const double width = cut_out ? windows.display_right - windows.display_left + 1 : frame.width;
  const double height = cut_out ? windows.display_bottom - windows.display_top + 1 : frame.height;
  const double left = cut_out ? windows.x - windows.display_left : 0,
               top = cut_out ? windows.y - windows.display_top : 0;
  RayGrid grid;
  grid.right_step = float(1 / (width * slope_x));
  grid.down_step = float(1 / (height * slope_y));
  grid.left = float(((left + 0.5) / width - offset_x) / slope_x);
  grid.top = float(((top + 0.5) / height - offset_y) / slope_y);
  const bool finite = std::isfinite(grid.left) && std::isfinite(grid.top) && std::isfinite(grid.right_step) &&
                      std::isfinite(grid.down_step);
  return finite ? std::make_optional(grid) : std::nullopt;
}

bool holds_split(const Frame& frame) {
  return frame.holds("direct") && frame.holds("indirect");
}

/// Reads the rows of one frame.
class GuideReader {
 public:
  GuideReader(const Frame& frame, const IlluminationSettings& settings)
      : frame_(frame),
        turn_(view_to_world(frame.info)),
        rays_(ray_grid(frame)),
        has_depth_(frame.holds("depth")),
        has_normal_(frame.holds("normal")),
        has_id_(frame.holds("id")),
        has_flow_(frame.holds("flow")),
        has_flow_depth_(frame.holds("flow_depth")),
        has_emission_(frame.holds("emission")),
        demodulates_(settings.demodulate && frame.holds("albedo")),
        splits_(settings.split && holds_split(frame)) {}

  int signals() const { return splits_ ? 2 : 1; }
  bool has_position() const { return rays_ && has_depth_; }
  bool has_flow() const { return has_flow_; }

  void read_surfaces(int64_t y, Surfaces& surfaces) const {
    for (int x = 0; x < frame_.width; ++x) {
      const size_t pixel = size_t(y) * size_t(frame_.width) + size_t(x);
      const int s = representative_sample(frame_, pixel);
      const auto value = [&](int channel) { return frame_.plane(s, channel)[pixel]; };
      const float depth = s < 0 ? kEscapedDepth : has_depth_ ? value(kDepthOffset) : 1.0F;
      const bool is_surface = depth < kEscapedDepth;
      const Vector3 normal =
          is_surface && has_normal_
              ? world_normal(value(kNormalOffset), value(kNormalOffset + 1), value(kNormalOffset + 2))
              : Vector3{0, 0, 1};
      surfaces.of.row(y, kId)[x] = !is_surface ? std::numeric_limits<float>::quiet_NaN()
                                   : has_id_   ? value(kIdOffset)
                                               : 0.0F;
      for (int c = 0; c < 3; ++c) surfaces.of.row(y, kNormalX + c)[x] = normal[size_t(c)];
      surfaces.of.row(y, kDepth)[x] = depth;
      surfaces.of.row(y, kPositionX)[x] = rays_ ? (rays_->left + float(x) * rays_->right_step) * depth : 0.0F;
      surfaces.of.row(y, kPositionY)[x] = rays_ ? (rays_->top + float(y) * rays_->down_step) * depth : 0.0F;
      surfaces.of.row(y, kPositionZ)[x] = depth;
      surfaces.flow.row(y, 0)[x] = s >= 0 && has_flow_ ? value(kFlowOffset) : 0.0F;
      surfaces.flow.row(y, 1)[x] = s >= 0 && has_flow_ ? value(kFlowOffset + 1) : 0.0F;
      surfaces.flow.row(y, 2)[x] = s >= 0 && has_flow_depth_ ? value(kFlowDepthOffset) : 0.0F;
    }
  }

  void read_light(int64_t y, Illumination& light) const {
    const int width = frame_.width;
    const size_t first = size_t(y) * size_t(width);
    std::vector<float> share(static_cast<size_t>(width)), other(share.size());
    for (int s = 0; s < frame_.spp; ++s)
      for (int x = 0; x < width; ++x)
        share[size_t(x)] += frame_.valid_plane(s)[first + size_t(x)] != 0 ? 1.0F : 0.0F;
    for (float& count : share) count = 1 / std::max(count, 1.0F);
    for (int c = 0; c < 3; ++c) {
      float *const albedo = light.albedo.row(y, c), *const emission = light.emission.row(y, c);
      if (demodulates_) {
        mean_row(first, albedo_ + c, share, albedo);
        mean_row(first, specular_ + c, share, other.data());
        for (int x = 0; x < width; ++x) albedo[x] = std::max(albedo[x] + other[size_t(x)], kLeastAlbedo);
      } else {
        std::fill_n(albedo, width, 1.0F);
      }
      emission_row(first, c, share, emission);
      float* const signal = light.signals.row(y, c);
      if (splits_) {
        float* const indirect = light.signals.row(y, 3 + c);
        mean_row(first, kDirectOffset + c, share, signal);
        mean_row(first, kIndirectOffset + c, share, indirect);
        divide_row(indirect, albedo);
      } else {
        mean_row(first, kRadianceOffset + c, share, signal);
        for (int x = 0; x < width; ++x) signal[x] -= emission[x];
      }
      divide_row(signal, albedo);
    }
  }

 private:
  Vector3 world_normal(float x, float y, float z) const {
    Vector3 n = {x, y, z};
    if (turn_)
      for (size_t r = 0; r < 3; ++r)
        n[r] = (*turn_)[3 * r] * x + (*turn_)[3 * r + 1] * y + (*turn_)[3 * r + 2] * z;
    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 1e-6F)) return {0, 0, 1};  // volumes have none
    for (float& c : n) c /= length;
    return n;
  }

  /// Mean over the samples that were drawn: the others are 0.
  void mean_row(size_t first, int channel, const std::vector<float>& share, float* out) const {
    const size_t width = share.size();
    std::copy_n(frame_.plane(0, channel) + first, width, out);
    if (frame_.spp == 1) return;
    for (size_t x = 0; x < width; ++x) out[x] *= share[x];
    for (int s = 1; s < frame_.spp; ++s) {
      const float* const plane = frame_.plane(s, channel) + first;
      for (size_t x = 0; x < width; ++x) out[x] += plane[x] * share[x];
    }
  }

  void emission_row(size_t first, int c, const std::vector<float>& share, float* out) const {
    if (has_emission_) {
      mean_row(first, kEmissionOffset + c, share, out);
      return;
    }
    std::fill_n(out, share.size(), 0.0F);
    if (!has_depth_) return;
    for (int s = 0; s < frame_.spp; ++s) {
      const float *const radiance = frame_.plane(s, kRadianceOffset + c) + first, *const depth =
                                                                                      frame_.plane(
                                                                                          s, kDepthOffset) +
                                                                                      first;
      for (size_t x = 0; x < share.size(); ++x)
        out[x] += depth[x] >= kEscapedDepth ? radiance[x] * share[x] : 0.0F;
    }
  }

  void divide_row(float* signal, const float* albedo) const {
    for (int x = 0; x < frame_.width; ++x) signal[x] = std::min(signal[x] / albedo[x], kLargestSignal);
  }

  const Frame& frame_;
  std::optional<std::array<float, 9>> turn_;
  std::optional<RayGrid> rays_;
  int albedo_ = find_feature("albedo").offset, specular_ = find_feature("specular").offset;
  bool has_depth_, has_normal_, has_id_, has_flow_, has_flow_depth_, has_emission_, demodulates_, splits_;
};

}  // namespace

std::vector<std::string> filter_features() {
  return {"normal", "depth",      "albedo", "specular", "flow",
          "id",     "flow_depth", "direct", "indirect", "emission"};
}

std::vector<std::string> missing_guides(const Frame& frame, bool temporal) {
  std::vector<std::string> lines;
  const auto need = [&](bool there, const char* line) {
    if (!there) lines.emplace_back(line);
  };
  need(frame.holds("albedo"), "no albedo: textures are filtered with the light");
  need(frame.holds("normal"), "no normal: all surfaces count as facing the camera");
  need(frame.holds("depth"), "no depth: all surfaces count as equally far");
  need(frame.holds("id"), "no id: all surfaces count as one object's");
  need(holds_split(frame), "no direct and indirect: both are filtered as one");
  need(frame.holds("emission"), "no emission: lights that the camera sees are filtered as surfaces are");
  if (!frame.info.world_to_camera || !frame.info.world_to_ndc)
    lines.emplace_back(
        temporal ? "no worldToCamera or worldToNDC: normals of different frames are compared in view space"
                 : "no worldToCamera or worldToNDC: depths are compared instead of positions");
  if (!temporal) return lines;
  need(frame.holds("flow"), "no flow: every frame is filtered by itself");
  need(frame.holds("flow_depth") || !frame.holds("flow"),
       "no flow.Z: surfaces count as having been as far in the previous frame");
  return lines;
}

void read_guides(const Frame& frame, const IlluminationSettings& settings, Surfaces& surfaces,
                 Illumination& light, int threads) {
  const GuideReader reader(frame, settings);
  const int width = frame.width, height = frame.height;
  surfaces.resize(width, height);
  surfaces.unit = frame.info.depth_scale > 0 ? frame.info.depth_scale / 10 : 1.0F;
  surfaces.has_flow = reader.has_flow() && !frame.info.cut;
  surfaces.has_position = reader.has_position();
  resize(light.albedo, width, height, 3);
  resize(light.emission, width, height, 3);
  resize(light.signals, width, height, 3 * reader.signals());
  parallel_for(threads, height, [&](int64_t y, int) {
    reader.read_surfaces(y, surfaces);
    reader.read_light(y, light);
  });
}

}  // namespace ld
