#include "render/geometry/camera.h"

#include <fmt/format.h>

#include "render/geometry/motion.h"

namespace ld {

Camera Camera::at(float time) const {
  Camera still = *this;
  still.close.reset();
  if (moves()) {
    still.position = mix(position, close->position, time);
    still.axes = interpolate(axes, close->axes, time);
  }
  return still;
}

Camera Camera::at_previous() const {
  Camera still = *this;
  still.close.reset();
  if (previous) {
    still.position = previous->position;
    still.axes = previous->axes;
  }
  return still;
}

Ray Camera::ray(const CameraSample& sample) const {
  const float focal = focal_pixels();
  const Vec3 through = {(sample.x - 0.5F * static_cast<float>(width)) / focal,
                        (0.5F * static_cast<float>(height) - sample.y) / focal, -1};
  const Vec3 on_lens = {lens_radius * sample.lens.x, lens_radius * sample.lens.y, 0};
  const Vec3 in_focus = through * focus_distance;
  return {position + axes.to_world(on_lens), normalize(axes.to_world(in_focus - on_lens))};
}

Vec2 Camera::project(Vec3 point) const {
  const Vec3 view = axes.to_local(point - position);
  const float scale = focal_pixels() / -view.z;
  return {0.5F * static_cast<float>(width) + view.x * scale,
          0.5F * static_cast<float>(height) - view.y * scale};
}

std::string Camera::describe() const {
  return fmt::format(
      "position {:g} {:g} {:g}; right {:g} {:g} {:g}; up {:g} {:g} {:g}; vertical fov {:g} rad; lens radius "
      "{:g}; focus distance {:g}; shutter {}",
      position.x, position.y, position.z, axes.x.x, axes.x.y, axes.x.z, axes.y.x, axes.y.y, axes.y.z, fov,
      lens_radius, focus_distance,
      !shutter ? "instant"
      : close  ? "open, moving"
               : "open");
}

Basis look_at(Vec3 position, Vec3 target, Vec3 up, float roll) {
  Basis axes;
  axes.z = normalize(position - target);
  const Vec3 right = normalize(cross(up, axes.z));
  const Vec3 upright = cross(axes.z, right);
  axes.x = right * std::cos(roll) + upright * std::sin(roll);
  axes.y = cross(axes.z, axes.x);
  return axes;
}

}  // namespace ld
