// Where what mirrors and smooth glass show appears to be: straight on along the ray that left the camera, as
// far away as the path is long. For plane mirrors this is the virtual image of optics.
#pragma once

#include "render/geometry/vec3.h"

namespace ld {

class VirtualImage {
 public:
  /// A perfectly specular surface at `position` turned the unit direction `in` into `out`.
  void pass(Vec3 position, Vec3 in, Vec3 out, bool reflected) {
    shown_ = this->position(position);
    real_ = position;
    // What takes `out` to `in`: a reflection, or for what is refracted two of them, which is the least turn.
    const auto back = [&](Vec3 v) {
      return reflected ? mirrored(v, out - in) : mirrored(mirrored(v, out), out + in);
    };
    axes_ = {direction(back({1, 0, 0})), direction(back({0, 1, 0})), direction(back({0, 0, 1}))};
  }

  /// Where a point or direction of the scene appears, seen by way of all surfaces passed so far.
  Vec3 position(Vec3 point) const { return shown_ + direction(point - real_); }
  Vec3 direction(Vec3 v) const { return axes_.to_world(v); }

 private:
  /// By the plane through the origin with this normal, of any length.
  static Vec3 mirrored(Vec3 v, Vec3 normal) {
    const float square = dot(normal, normal);
    return square > 0 ? v - normal * (2 * dot(v, normal) / square) : v;
  }

  Vec3 real_, shown_;  // the last surface passed, where it is and where it appears
  Basis axes_;         // how the scene's appear behind it; left-handed after an odd number of mirrors
};

}  // namespace ld
