// A thin-lens camera. Pixel coordinates: x to the right, y down, (0, 0) the picture's upper left corner,
// pixel (i, j) covering [i, i+1) x [j, j+1). View space is right-handed: +x right, +y up, +z towards the
// camera.
#pragma once

#include <optional>
#include <string>

#include "render/geometry/sampling.h"

namespace ld {

struct Ray {
  Vec3 origin, direction;  // direction of unit length
};

/// Where on the picture, on the lens and in time a sample was taken.
struct CameraSample {
  float x = 0, y = 0;  // pixel coordinates
  Vec2 lens;           // unit disk, +x right, +y up
  float time = 0;      // 0 shutter open, 1 shutter close
};

/// Where a camera stands and how it is turned.
struct CameraPose {
  Vec3 position;
  Basis axes;  // as Camera::axes
};

struct Camera {
  Vec3 position;
  Basis axes;                // of view space, in world coordinates: right, up, towards the viewer
  float fov = 0.8F;          // vertical, radians
  float lens_radius = 0;     // scene units; 0: a pinhole
  float focus_distance = 1;  // scene units along the view axis
  bool shutter = false;      // false: an instant at time 0
  int width = 0, height = 0;
  std::optional<CameraPose>
      close;  // at shutter close, where it moves; `position` and `axes` are at shutter open
  std::optional<CameraPose> previous;  // at the previous frame's shutter open, in a sequence

  /// Pixels that one scene unit at depth 1 covers.
  float focal_pixels() const { return 0.5F * static_cast<float>(height) / std::tan(0.5F * fov); }

  /// The camera as it stands at a time of the shutter interval: straight from one place to the other, turning
  /// evenly. The result does not move.
  Camera at(float time) const;
  /// As it stood at the previous frame's shutter open.
  Camera at_previous() const;

  /// Of a camera that does not move, see at().
  Ray ray(const CameraSample& sample) const;
  /// From where the camera is at the sample's time.
  Ray ray_at(const CameraSample& sample) const { return moves() ? at(sample.time).ray(sample) : ray(sample); }
  bool moves() const { return close && shutter; }

  /// Distance along the view axis.
  float depth(Vec3 point) const { return -dot(point - position, axes.z); }

  /// Pixel coordinates of a point seen through the centre of the lens; its depth must be above 0.
  Vec2 project(Vec3 point) const;

  Vec3 to_view(Vec3 direction) const { return axes.to_local(direction); }

  /// Signed radius in pixels of the disk that a point at this depth blurs to, positive behind the focal
  /// plane: the lens as seen from the point, projected onto the focal plane, lens_radius |depth - focus| /
  /// depth in scene units.
  float circle_of_confusion(float depth) const {
    return lens_radius * (1 / focus_distance - 1 / depth) * focal_pixels();
  }
  /// The same for depth to infinity.
  float circle_of_confusion_at_infinity() const { return lens_radius / focus_distance * focal_pixels(); }

  std::string describe() const;
};

/// Axes of a camera at `position` that looks at `target`; `up` need not be perpendicular. `roll` in radians.
Basis look_at(Vec3 position, Vec3 target, Vec3 up, float roll = 0);

}  // namespace ld
