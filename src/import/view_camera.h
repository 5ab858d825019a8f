// The camera of an imported picture: what turns world space into view space and distances into depths.
#pragma once

#include <ImathMatrix.h>
#include <ImathVec.h>
#include <ImfHeader.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/config_keys.h"
#include "frame/frame.h"

namespace ld {

/// View space: +x right, +y up, the camera looks along -z.
struct ViewCamera {
  Imath::V3d right{1, 0, 0}, up{0, 1, 0}, back{0, 0, 1};  // in world space, orthonormal, right-handed
  Imath::V3d position{0, 0, 0};
  std::optional<double> fov_y;  // vertical field of view in radians
  int width = 0, height = 0;    // of the picture it was made for; 0: not said
  std::string origin;           // file or attribute, for complaints

  Imath::V3d direction_to_view(const Imath::V3d& world) const {
    return {world.dot(right), world.dot(up), world.dot(back)};
  }
  Imath::V3d point_to_view(const Imath::V3d& world) const { return direction_to_view(world - position); }
};

/// The whole picture (display window) that a frame's pixels lie in; pixels are square.
struct Picture {
  double left, top, width, height;
};
Picture picture_of(int width, int height, const Windows& windows);

/// Where the ray through the middle of the pixel (x, y) of the data window crosses the plane z = -1 of view
/// space.
Imath::V3d ray_through(const Picture& picture, const Windows& windows, double fov_y, int x, int y);

/// Reads camera_to_world (4 rows of 4 numbers, for column vectors) or position, look_at and up; fov_y; width,
/// height. Throws UsageError: neither or both, a matrix that does more than turn, move and scale evenly.
ViewCamera read_camera(const std::filesystem::path& path);

/// The keys of such a file.
std::vector<ConfigKey> camera_keys();

/// The camera of the attribute worldToCamera, if there is one: OpenEXR's 4x4 matrix for row vectors; one that
/// has its translation in the last column is read as for column vectors. A left-handed camera looks along +z,
/// a right-handed one along -z; +x is right and +y up in both.
std::optional<ViewCamera> camera_of(const Imf::Header& header, const std::string& path);

}  // namespace ld
