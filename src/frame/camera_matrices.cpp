#include "frame/camera_matrices.h"

#include <algorithm>

namespace ld {
namespace {

using Triple = std::array<double, 3>;

double dot_product(const Triple& a, const Triple& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Triple cross_product(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A column of world_to_camera: how far a point lies along an axis.
struct Along {
  Triple axis;
  double offset;
};

Along along(const CameraPlace& camera, const Triple& axis, double sign) {
  const Triple signed_axis = {sign * axis[0], sign * axis[1], sign * axis[2]};
  return {signed_axis, -dot_product(camera.position, signed_axis)};
}

Along sum(const Along& a, double factor_a, const Along& b, double factor_b) {
  Along result = {{}, factor_a * a.offset + factor_b * b.offset};
  for (size_t i = 0; i < 3; ++i) result.axis[i] = factor_a * a.axis[i] + factor_b * b.axis[i];
  return result;
}

Matrix4 from_columns(const std::array<Along, 4>& columns) {
  Matrix4 m{};
  for (size_t c = 0; c < 4; ++c) {
    for (size_t i = 0; i < 3; ++i) m[4 * i + c] = static_cast<float>(columns[c].axis[i]);
    m[12 + c] = static_cast<float>(columns[c].offset);
  }
  return m;
}

constexpr Along kOne = {{0, 0, 0}, 1};

}  // namespace

Matrix4 world_to_camera(const CameraPlace& camera) {
  return from_columns(
      {along(camera, camera.right, 1), along(camera, camera.up, 1), along(camera, camera.back, -1), kOne});
}

Matrix4 world_to_ndc(const CameraPlace& camera, double half_width, double half_height) {
  const Along right = along(camera, camera.right, 1), up = along(camera, camera.up, 1),
              depth = along(camera, camera.back, -1);
  // The third coordinate means nothing in OpenEXR; this one gives the matrix an inverse.
  return from_columns(
      {sum(right, 0.5 / half_width, depth, 0.5), sum(up, -0.5 / half_height, depth, 0.5), kOne, depth});
}

CameraPlace camera_place(const Matrix4& m) {
  // p M = x r + y u - z b + t, so that the rows of the inverse are the columns' cross products over their
  // triple product.
  const auto column = [&](size_t c) { return Triple{m[c], m[4 + c], m[8 + c]}; };
  const Triple right = column(0), up = column(1), forward = column(2);
  const Triple rows[3] = {cross_product(up, forward), cross_product(forward, right),
                          cross_product(right, up)};
  const double volume = dot_product(right, rows[0]);
  CameraPlace place{};
  Triple* const axes[3] = {&place.right, &place.up, &place.back};
  for (size_t a = 0; a < 3; ++a)
    for (size_t i = 0; i < 3; ++i) {
      const double value = rows[a][i] / volume;
      place.position[i] -= m[12 + a] * value;
      (*axes[a])[i] = a == 2 ? -value : value;
    }
  return place;
}

Matrix4 camera_to_world(const Matrix4& world_to_camera) {
  const CameraPlace place = camera_place(world_to_camera);
  Matrix4 m{};
  for (size_t i = 0; i < 3; ++i) {
    const double row[4] = {place.right[i], place.up[i], place.back[i], place.position[i]};
    std::transform(row, row + 4, &m[4 * i], [](double value) { return static_cast<float>(value); });
  }
  m[15] = 1;
  return m;
}

std::array<double, 2> project_to_ndc(const Matrix4& m, const std::array<double, 3>& p) {
  const auto coordinate = [&](size_t c) {
    return p[0] * m[c] + p[1] * m[4 + c] + p[2] * m[8 + c] + m[12 + c];
  };
  const double w = coordinate(3);
  return {coordinate(0) / w, coordinate(1) / w};
}

}  // namespace ld
