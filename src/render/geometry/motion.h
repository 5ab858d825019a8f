// Rigid motion over an interval of time: what an object does while the shutter is open, or since the previous
// frame.
#pragma once

#include "render/geometry/vec3.h"

namespace ld {

/// Turned by angle * time about `axis` through `pivot`, then moved by translation * time. The turn is cut
/// into steps of a few degrees between which points go straight, so that surfaces are where the ray tracer,
/// which knows nothing else, finds them.
struct Motion {
  Vec3 translation;  // scene units
  Vec3 axis = {0, 1, 0};
  float angle = 0;  // radians
  Vec3 pivot;

  Motion() = default;
  Motion(Vec3 move) : translation(move) {}  // NOLINT(google-explicit-constructor): a translation is a motion

  bool still() const { return angle == 0 && is_black(translation); }
  /// Straight pieces of the way; at least 1.
  int pieces() const;

  /// Where a point that is at `p` at time 0 is at `time`.
  Vec3 point(Vec3 p, float time) const;
  Vec3 direction(Vec3 d, float time) const;
};

/// Rodrigues' rotation of v by `angle` about a unit axis.
Vec3 rotate(Vec3 v, Vec3 axis, float angle);

/// The rotation that takes basis `a` to basis `b`, by the share t of its angle, applied to `a`.
Basis interpolate(const Basis& a, const Basis& b, float t);

}  // namespace ld
