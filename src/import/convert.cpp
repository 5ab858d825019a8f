#include "import/convert.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace ld {
namespace {

bool is_escape_value(const FeatureMapping& mapping, float value) {
  return std::find(mapping.escaped_at.begin(), mapping.escaped_at.end(), static_cast<double>(value)) !=
         mapping.escaped_at.end();
}

/// Whether the channels say that the ray met nothing.
bool escaped(const FeatureMapping& mapping, const std::vector<std::vector<float>>& raw, size_t pixel) {
  if (mapping.is_position())
    return std::all_of(raw.begin(), raw.end(), [&](const auto& plane) {
      return !std::isfinite(plane[pixel]) || is_escape_value(mapping, plane[pixel]);
    });
  const float value = raw[0][pixel];
  return std::isinf(value) || static_cast<double>(value) >= mapping.escaped_above ||
         is_escape_value(mapping, value);
}

}  // namespace

bool needs_camera(const FeatureMapping& mapping) {
  return needs_fov(mapping) || (mapping.feature == "normal" && mapping.space == "world") ||
         mapping.kind == "world_position";
}

bool needs_fov(const FeatureMapping& mapping) {
  return (mapping.feature == "normal" && mapping.face_camera) || mapping.kind == "distance";
}

Converter::Converter(int width, int height, const Windows& windows, std::optional<ViewCamera> camera)
    : width_(width),
      windows_(windows),
      picture_(picture_of(width, height, windows)),
      camera_(std::move(camera)) {
  if (camera_ && camera_->width > 0 && camera_->height > 0 &&
      (camera_->width != picture_.width || camera_->height != picture_.height))
    fail_usage("{}: a camera for {} x {} pixels, but the picture has {} x {}; expected the same",
               camera_->origin, camera_->width, camera_->height, picture_.width, picture_.height);
}

const ViewCamera& Converter::need_camera(const FeatureMapping& mapping, const std::string& what) const {
  if (!camera_)
    fail_usage(
        "{} comes as {}, which needs the camera: give --camera FILE.yaml, or leave the feature out with "
        "--set "
        "{}.channels=[]",
        mapping.feature, what, mapping.feature);
  return *camera_;
}

double Converter::need_fov(const FeatureMapping& mapping, const std::string& what) const {
  const ViewCamera& camera = need_camera(mapping, what);
  if (!camera.fov_y)
    fail_usage("{}: no field of view, but {} comes as {}; add fov_y, in radians", camera.origin,
               mapping.feature, what);
  return *camera.fov_y;
}

Imath::V3d Converter::ray_of(size_t pixel, double fov) const {
  const auto width = static_cast<size_t>(width_);
  return ray_through(picture_, windows_, fov, static_cast<int>(pixel % width),
                     static_cast<int>(pixel / width));
}

void Converter::normals(const FeatureMapping& mapping, Planes& planes) const {
  const bool world = mapping.space == "world";
  const ViewCamera* camera = world ? &need_camera(mapping, "normals in world space") : nullptr;
  const double fov = mapping.face_camera ? need_fov(mapping, "normals that may look away (face_camera)") : 0;
  // Within half a pixel of a silhouette nobody can say which way a normal looks.
  const double tolerance = fov / picture_.height;
  for (size_t p = 0; p < planes[0].size(); ++p) {
    Imath::V3d normal(planes[0][p], planes[1][p], planes[2][p]);
    if (world) normal = camera->direction_to_view(normal);
    if (mapping.space == "view_z_forward") normal.z = -normal.z;
    const double length = normal.length();
    if (length > 1e-6) normal /= length;  // also of a mean over samples
    if (length <= 1e-6) normal = {0, 0, 0};
    if (mapping.face_camera && normal.dot(ray_of(p, fov).normalized()) > tolerance) normal = -normal;
    for (unsigned c = 0; c < 3; ++c) planes[c][p] = static_cast<float>(normal[c]) + 0.0F;  // no -0
  }
}

double Converter::depth_at(const FeatureMapping& mapping, const Planes& scaled, size_t pixel) const {
  if (mapping.is_position()) {
    const Imath::V3d point(scaled[0][pixel], scaled[1][pixel], scaled[2][pixel]);
    if (mapping.kind == "world_position") return -camera_->point_to_view(point).z;
    return mapping.kind == "view_position" ? -point.z : point.z;
  }
  double value = scaled[0][pixel];
  if (mapping.inverse) value = 1 / value;
  if (mapping.kind == "distance") value /= ray_of(pixel, *camera_->fov_y).length();  // |z| = 1: the cosine
  return value + mapping.near;
}

Converter::Planes Converter::depth(const FeatureMapping& mapping, const Planes& raw, const Planes& scaled) {
  if (mapping.kind == "world_position") need_camera(mapping, "positions in world space");
  if (mapping.kind == "distance") need_fov(mapping, "the distance along the ray");
  Planes result(1, std::vector<float>(raw[0].size(), kEscapedDepth));
  for (size_t p = 0; p < raw[0].size(); ++p) {
    // 1 / depth is 0 at infinity.
    if (escaped(mapping, raw, p) || (mapping.inverse && raw[0][p] == 0)) continue;
    const double value = depth_at(mapping, scaled, p);
    if (value >= static_cast<double>(kEscapedDepth)) ++counts_.beyond_half;
    result[0][p] = static_cast<float>(std::min(value, static_cast<double>(kEscapedDepth)));
  }
  return result;
}

void Converter::movement(const FeatureMapping& mapping, Planes& planes) const {
  if (mapping.unit == "pixels") return;
  const bool ndc = mapping.unit == "ndc";  // 2 across the picture, +y up
  const double x = ndc ? picture_.width / 2 : picture_.width,
               y = ndc ? -picture_.height / 2 : picture_.height;
  for (float& value : planes[0]) value = static_cast<float>(value * x) + 0.0F;
  for (float& value : planes[1]) value = static_cast<float>(value * y) + 0.0F;
}

std::vector<std::vector<float>> Converter::convert(const FeatureMapping& mapping, Planes channels) {
  Planes raw;
  if (mapping.feature == "depth") raw = channels;
  for (size_t c = 0; c < channels.size(); ++c) {
    const auto scale = static_cast<float>(mapping.scale[c]), offset = static_cast<float>(mapping.offset[c]);
    if (scale == 1 && offset == 0) continue;
    for (float& value : channels[c]) value = scale * value + offset + 0.0F;
  }
  if (mapping.feature == "depth") return depth(mapping, raw, channels);
  if (mapping.feature == "normal") normals(mapping, channels);
  if (mapping.feature == "motion" || mapping.feature == "flow") movement(mapping, channels);
  if (mapping.kind == "alpha")
    for (float& value : channels[0]) value = std::sqrt(std::max(value, 0.0F));  // GGX alpha = roughness^2
  if (mapping.maximum < kHalfMax)
    for (std::vector<float>& plane : channels)
      for (float& value : plane) {
        const auto maximum = static_cast<float>(mapping.maximum);
        if (!(value > maximum)) continue;
        ++counts_.above_maximum;
        value = maximum;
      }
  return channels;
}

}  // namespace ld
