// Three floats: points and directions in scene units, and linear RGB colours; two floats; and orthonormal
// bases.
#pragma once

#include <algorithm>
#include <cmath>

namespace ld {

constexpr float kPi = 3.14159265358979F;

struct Vec2 {
  float x = 0, y = 0;
};

struct Vec3 {
  float x = 0, y = 0, z = 0;
  float& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  float operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
};

inline Vec3 operator+(Vec3 a, Vec3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(Vec3 a, Vec3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator-(Vec3 a) {
  return {-a.x, -a.y, -a.z};
}
inline Vec3 operator*(Vec3 a, Vec3 b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
inline Vec3 operator*(Vec3 a, float s) {
  return {a.x * s, a.y * s, a.z * s};
}
inline Vec3 operator*(float s, Vec3 a) {
  return a * s;
}
inline Vec3 operator/(Vec3 a, Vec3 b) {
  return {a.x / b.x, a.y / b.y, a.z / b.z};
}
inline Vec3 operator/(Vec3 a, float s) {
  return a * (1 / s);
}
inline Vec3& operator+=(Vec3& a, Vec3 b) {
  return a = a + b;
}
inline Vec3& operator*=(Vec3& a, Vec3 b) {
  return a = a * b;
}
inline Vec3& operator*=(Vec3& a, float s) {
  return a = a * s;
}

inline float dot(Vec3 a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float length(Vec3 a) {
  return std::sqrt(dot(a, a));
}
inline Vec3 normalize(Vec3 a) {
  return a / length(a);
}
inline Vec3 mix(Vec3 a, Vec3 b, float t) {
  return a * (1 - t) + b * t;
}
inline Vec3 grey(float v) {
  return {v, v, v};
}
inline float max_component(Vec3 a) {
  return std::max(a.x, std::max(a.y, a.z));
}
inline bool is_black(Vec3 a) {
  return a.x == 0 && a.y == 0 && a.z == 0;
}
/// Rec. 709 luminance of a linear colour.
inline float luminance(Vec3 c) {
  return 0.2126F * c.x + 0.7152F * c.y + 0.0722F * c.z;
}

/// A right-handed orthonormal basis. Locally z is the normal.
struct Basis {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  Vec3 to_local(Vec3 v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  Vec3 to_world(Vec3 v) const { return x * v.x + y * v.y + z * v.z; }
};

/// Duff et al., "Building an orthonormal basis, revisited", JCGT 2017.
inline Basis basis_around(Vec3 n) {
  const float sign = std::copysign(1.0F, n.z);
  const float a = -1 / (sign + n.z);
  const float b = n.x * n.y * a;
  return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

constexpr Vec3 kX = {1, 0, 0}, kY = {0, 1, 0}, kZ = {0, 0, 1};

}  // namespace ld
