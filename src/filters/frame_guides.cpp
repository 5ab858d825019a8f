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
        per_sample_(demodulates_ && settings.per_sample && frame.spp > 1),
        splits_(settings.split && holds_split(frame)) {}

  int signals() const { return splits_ ? 2 : 1; }
  bool has_position() const { return rays_ && has_depth_; }
  bool has_flow() const { return has_flow_; }

  void read_surfaces(int64_t y, Surfaces& surfaces) const {
    const int width = frame_.width;
    const size_t first = size_t(y) * size_t(width);
    std::vector<int> chosen(static_cast<size_t>(width));  // the sample of each pixel; -1: none
    for (int x = 0; x < width; ++x) chosen[size_t(x)] = representative_sample(frame_, first + size_t(x));
    float* const depth = surfaces.of.row(y, kDepth);
    pick_row(has_depth_, first, kDepthOffset, chosen, 1, depth);
    for (int x = 0; x < width; ++x) depth[x] = chosen[size_t(x)] < 0 ? kEscapedDepth : depth[x];

    float* const id = surfaces.of.row(y, kId);
    pick_row(has_id_, first, kIdOffset, chosen, 0, id);
    for (int x = 0; x < width; ++x)
      id[x] = depth[x] < kEscapedDepth ? id[x] : std::numeric_limits<float>::quiet_NaN();
    read_normals(first, chosen, depth, surfaces.of, y);

    float *const place_x = surfaces.of.row(y, kPositionX), *const place_y = surfaces.of.row(y, kPositionY);
    const RayGrid rays = rays_.value_or(RayGrid());
    const float slope_y = rays.top + float(y) * rays.down_step;
    for (int x = 0; x < width; ++x) {
      place_x[x] = (rays.left + float(x) * rays.right_step) * depth[x];
      place_y[x] = slope_y * depth[x];
    }
    std::copy_n(depth, width, surfaces.of.row(y, kPositionZ));
    for (int c = 0; c < 3; ++c)
      pick_row(c < 2 ? has_flow_ : has_flow_depth_, first, c < 2 ? kFlowOffset + c : kFlowDepthOffset, chosen,
               0, surfaces.flow.row(y, c));
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
      if (per_sample_) {
        quotient_row(first, splits_ ? kDirectOffset : kRadianceOffset, c, share, signal);
        if (splits_) quotient_row(first, kIndirectOffset, c, share, light.signals.row(y, 3 + c));
        continue;
      }
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
  /// A channel of the chosen samples; `without` where there is none and where the frame has no such channel.
  void pick_row(bool there, size_t first, int channel, const std::vector<int>& chosen, float without,
                float* out) const {
    const size_t width = chosen.size();
    const float* const plane = there ? frame_.plane(0, channel) + first : nullptr;
    if (!there)
      std::fill_n(out, width, without);
    else if (frame_.spp == 1)
      for (size_t x = 0; x < width; ++x) out[x] = chosen[x] < 0 ? without : plane[x];
    else
      for (size_t x = 0; x < width; ++x)
        out[x] = chosen[x] < 0 ? without : frame_.plane(chosen[x], channel)[first + x];
  }

  /// Unit normals in world space; those of volumes, which have none, and of pixels without a surface point to
  /// the viewer.
  void read_normals(size_t first, const std::vector<int>& chosen, const float* depth, RowPlanes& out,
                    int64_t y) const {
    const int width = frame_.width;
    float *const nx = out.row(y, kNormalX), *const ny = out.row(y, kNormalY),
                 *const nz = out.row(y, kNormalZ);
    for (int c = 0; c < 3; ++c)
      pick_row(has_normal_, first, kNormalOffset + c, chosen, c == 2 ? 1.0F : 0.0F, out.row(y, kNormalX + c));
    if (!has_normal_) return;
    constexpr std::array<float, 9> kNoTurn = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::array<float, 9> t = turn_.value_or(kNoTurn);
    for (int x = 0; x < width; ++x) {
      const float a = nx[x], b = ny[x], c = nz[x];
      const float u = t[0] * a + t[1] * b + t[2] * c, v = t[3] * a + t[4] * b + t[5] * c,
                  w = t[6] * a + t[7] * b + t[8] * c;
      const float length = std::sqrt(u * u + v * v + w * w);
      const bool is_unit = length > 1e-6F && depth[x] < kEscapedDepth;
      nx[x] = is_unit ? u / length : 0.0F;
      ny[x] = is_unit ? v / length : 0.0F;
      nz[x] = is_unit ? w / length : 1.0F;
    }
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

  /// Mean over the samples of (C_s - E_s) / A_s. Where S and A change together in a pixel, as at edges, that
  /// times the mean of A is not the mean of C.
  void quotient_row(size_t first, int channel, int c, const std::vector<float>& share, float* out) const {
    std::fill_n(out, share.size(), 0.0F);
    for (int s = 0; s < frame_.spp; ++s) {
      const auto plane = [&](int at) { return frame_.plane(s, at) + first; };
      const float *const light = plane(channel + c), *const albedo = plane(albedo_ + c),
                         *const specular = plane(specular_ + c), *const emission = plane(kEmissionOffset + c),
                         *const depth = plane(kDepthOffset);
      for (size_t x = 0; x < share.size(); ++x) {
        float own = light[x];
        if (channel == kRadianceOffset) {
          if (has_emission_)
            own -= emission[x];
          else if (has_depth_ && depth[x] >= kEscapedDepth)
            own = 0;
        }
        const float s_s = own / std::max(albedo[x] + specular[x], kLeastAlbedo);
        out[x] += std::min(s_s, kLargestSignal) * share[x];
      }
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
  bool has_depth_, has_normal_, has_id_, has_flow_, has_flow_depth_, has_emission_, demodulates_, per_sample_,
      splits_;
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
