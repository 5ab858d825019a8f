#include "import/view_camera.h"

#include <ImfMatrixAttribute.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/config_visitor.h"
#include "core/error.h"

namespace ld {
namespace {

struct CameraConfig {
  std::vector<double> camera_to_world;  // four rows of four numbers, for column vectors
  std::vector<double> position;         // instead of camera_to_world
  std::vector<double> look_at;          // with `position`: a point in the middle of the picture
  std::vector<double> up = {0, 1, 0};   // with `position`: what is upwards in the picture
  double fov_y = 0;                     // vertical field of view, radians; 0: not known
  int64_t width = 0;                    // compared with the picture's display window; 0: not compared
  int64_t height = 0;                   // likewise

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("camera_to_world", camera_to_world);
    v.field("position", position);
    v.field("look_at", look_at);
    v.field("up", up);
    v.field("fov_y", fov_y, Range{0, 3.14159});
    v.field("width", width, Range{0, 1 << 20});
    v.field("height", height, Range{0, 1 << 20});
  }
};

/// Puts the rows of a matrix behind each other.
void flatten(ConfigNode& root, const std::string& key) {
  for (auto& [name, node] : root.entries) {
    if (name != key) continue;
    std::vector<ConfigNode> flat;
    for (ConfigNode& item : node.items) {
      if (item.kind != ConfigNode::Kind::list) {
        flat.push_back(std::move(item));
        continue;
      }
      for (ConfigNode& number : item.items) flat.push_back(std::move(number));
    }
    node.items = std::move(flat);
  }
}

Imath::V3d vector_of(const std::vector<double>& values, const std::string& where) {
  if (values.size() != 3) fail_usage("{}: {} numbers; expected three", where, values.size());
  return {values[0], values[1], values[2]};
}

/// Makes the axes unit vectors; they must be at right angles and right-handed.
void orthonormalise(ViewCamera& camera) {
  const double size = camera.right.length();
  for (Imath::V3d* axis : {&camera.right, &camera.up, &camera.back}) {
    const double length = axis->length();
    if (!(length > 1e-9) || !std::isfinite(length) || std::abs(length - size) > 1e-3 * size)
      fail_usage(
          "{}: the camera's axes have the lengths {:.4g}, {:.4g} and {:.4g}; expected equal ones above 0",
          camera.origin, size, camera.up.length(), camera.back.length());
    *axis /= length;
  }
  const double skew =
      std::max({std::abs(camera.right.dot(camera.up)), std::abs(camera.right.dot(camera.back)),
                std::abs(camera.up.dot(camera.back))});
  if (skew > 1e-3)
    fail_usage("{}: the camera's axes are not at right angles; expected no shear", camera.origin);
  if (camera.right.cross(camera.up).dot(camera.back) < 0)
    fail_usage(
        "{}: the camera's axes are left-handed; expected +x right, +y up and looking along -z: negate the "
        "third "
        "column of a camera that looks along +z, the first and the third where its +x is left",
        camera.origin);
}

}  // namespace

Picture picture_of(int width, int height, const Windows& windows) {
  if (!windows.has_display())
    return {static_cast<double>(windows.x), static_cast<double>(windows.y), static_cast<double>(width),
            static_cast<double>(height)};
  const double left = windows.display_left, top = windows.display_top;
  return {left, top, windows.display_right - left + 1, windows.display_bottom - top + 1};
}

Imath::V3d ray_through(const Picture& picture, const Windows& windows, double fov_y, int x, int y) {
  const double half_height = std::tan(fov_y / 2);
  const double px = windows.x + (x + 0.5) - picture.left, py = windows.y + (y + 0.5) - picture.top;
  return {(2 * px - picture.width) / picture.height * half_height,
          (1 - 2 * py / picture.height) * half_height, -1};
}

std::vector<ConfigKey> camera_keys() {
  return config_keys<CameraConfig>();
}

ViewCamera read_camera(const std::filesystem::path& path) {
  ConfigNode root = read_config(path);
  flatten(root, "camera_to_world");
  const auto config = config_from_tree<CameraConfig>(root);
  ViewCamera camera;
  camera.origin = path.string();
  if (config.camera_to_world.empty() == config.position.empty())
    fail_usage("{}: expected either camera_to_world or position with look_at", camera.origin);
  if (config.position.empty()) {
    const std::vector<double>& m = config.camera_to_world;
    if (m.size() != 16 || m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
      fail_usage(
          "{}: camera_to_world has {} numbers or does not end in 0, 0, 0, 1; expected four rows of four",
          camera.origin, m.size());
    camera.right = {m[0], m[4], m[8]};
    camera.up = {m[1], m[5], m[9]};
    camera.back = {m[2], m[6], m[10]};
    camera.position = {m[3], m[7], m[11]};
  } else {
    camera.position = vector_of(config.position, camera.origin + ": position");
    camera.back = camera.position - vector_of(config.look_at, camera.origin + ": look_at");
    camera.right = vector_of(config.up, camera.origin + ": up").cross(camera.back);
    if (!(camera.right.length() > 1e-9 * camera.back.length()))
      fail_usage("{}: the camera looks along `up` or at its own position; change up or look_at",
                 camera.origin);
    camera.back.normalize();
    camera.right.normalize();
    camera.up = camera.back.cross(camera.right);
  }
  orthonormalise(camera);
  if (config.fov_y > 0) camera.fov_y = config.fov_y;
  camera.width = static_cast<int>(config.width);
  camera.height = static_cast<int>(config.height);
  return camera;
}

std::optional<ViewCamera> camera_of(const Imf::Header& header, const std::string& path) {
  const auto* attribute = header.findTypedAttribute<Imf::M44fAttribute>("worldToCamera");
  if (attribute == nullptr) return std::nullopt;
  Imath::M44d m(attribute->value());
  const bool last_column = m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0;
  const bool last_row = m[3][0] != 0 || m[3][1] != 0 || m[3][2] != 0;
  if (last_column && !last_row) m.transpose();
  ViewCamera camera;
  camera.origin = path + ": the attribute worldToCamera";
  // Columns: where the world's point lies along the camera's x, y and z.
  camera.right = {m[0][0], m[1][0], m[2][0]};
  camera.up = {m[0][1], m[1][1], m[2][1]};
  camera.back = {m[0][2], m[1][2], m[2][2]};
  const Imath::V3d moved(m[3][0], m[3][1], m[3][2]);
  // p' = p R + t with R = size * rotation, so the camera (p' = 0) stands at -t R^-1.
  const double size = camera.right.length();
  if (size > 1e-9)
    camera.position = -(camera.right * moved.x + camera.up * moved.y + camera.back * moved.z) / (size * size);
  if (camera.right.cross(camera.up).dot(camera.back) < 0) camera.back = -camera.back;
  orthonormalise(camera);
  return camera;
}

}  // namespace ld
