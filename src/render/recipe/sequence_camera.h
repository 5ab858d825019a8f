// A camera's flight through a scene: a smooth curve that keeps clear of what it passes.
#pragma once

#include <vector>

#include "core/random.h"
#include "render/trace/prepared_scene.h"

namespace ld {

/// Places and points looked at, a knot every few frames, joined by a uniform Catmull-Rom spline.
class CameraPath {
 public:
  CameraPath(std::vector<Vec3> places, std::vector<Vec3> targets, Vec3 up, float frames_a_knot);

  /// At any time from a frame before the first to a frame after the last, in frames.
  CameraPose at(float frame) const;

 private:
  Vec3 spline(const std::vector<Vec3>& knots, float frame) const;

  std::vector<Vec3> places_, targets_;
  Vec3 up_;
  float frames_a_knot_;
};

/// A camera that moves by `step` (scene units) and turns by `angle` (radians, about its own up) each frame of
/// `length`. `scene` and what is in the way: as below, a slower path taking the place of one that is not
/// clear, down to a camera that stands.
CameraPath steady_path(const PreparedScene& scene, const Camera& start, Vec3 step, float angle,
                       int64_t length);

/// A path of `length` frames that begins at `start` looking at the point `distance` ahead of it. `scene` must
/// carry its objects from the first frame (time 0) to the last (time 1). Candidates that come near a surface
/// or pass through one are thrown away; each further one is slower, down to a camera that only turns. `speed`
/// scales the way a frame.
CameraPath plan_camera_path(const PreparedScene& scene, const Camera& start, float distance, int64_t length,
                            float speed, RandomStream& random);

}  // namespace ld
