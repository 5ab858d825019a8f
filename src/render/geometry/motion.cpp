#include "render/geometry/motion.h"

namespace ld {

Vec3 rotate(Vec3 v, Vec3 axis, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1 - c));
}

int Motion::pieces() const {
  constexpr float kPiece = 3 * kPi / 180;  // a chord of 3 degrees leaves its arc by 0.03 % of the radius
  return std::clamp(static_cast<int>(std::ceil(std::abs(angle) / kPiece)), 1, 120);
}

Vec3 Motion::point(Vec3 p, float time) const {
  if (angle == 0) return p + translation * time;
  const auto count = static_cast<float>(pieces());
  const float piece = std::min(std::floor(time * count), count - 1);
  const auto turned = [&](float step) { return rotate(p - pivot, axis, angle * step / count); };
  return mix(turned(piece), turned(piece + 1), time * count - piece) + pivot + translation * time;
}

Vec3 Motion::direction(Vec3 d, float time) const {
  return angle == 0 ? d : rotate(d, axis, angle * time);
}

Basis interpolate(const Basis& a, const Basis& b, float t) {
  // R = b a^T; its axis and angle from the antisymmetric part and the trace.
  Vec3 twice_sin;
  float trace = 0;
  for (int i = 0; i < 3; ++i) {
    const Vec3 from = i == 0 ? a.x : i == 1 ? a.y : a.z, to = i == 0 ? b.x : i == 1 ? b.y : b.z;
    twice_sin += cross(from, to);
    trace += dot(from, to);
  }
  const float angle = std::atan2(0.5F * length(twice_sin), 0.5F * (trace - 1));
  if (length(twice_sin) < 1e-6F)
    return t < 0.5F ? a : b;  // no turn, or a half one, whose axis is anyone's guess
  const Vec3 axis = normalize(twice_sin);
  Basis result;
  result.x = rotate(a.x, axis, t * angle);
  result.y = rotate(a.y, axis, t * angle);
  result.z = cross(result.x, result.y);
  return result;
}

}  // namespace ld
