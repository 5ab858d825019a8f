// Where the camera of a picture stood and what it saw: OpenEXR's standard attributes worldToCamera and
// worldToNDC (ImfStandardAttributes.h), which other renderers write as well, and what follows from them.
#pragma once

#include <array>

namespace ld {

/// Row by row, for points as rows: (x y z 1) M.
using Matrix4 = std::array<float, 16>;

/// A camera of square pixels. Its axes are unit vectors of the world: right, up and back, towards the viewer.
struct CameraPlace {
  std::array<double, 3> position, right, up, back;
};

/// To the space of OpenEXR's cameras, which is left-handed: +x right, +y up, +z the way the camera looks.
Matrix4 world_to_camera(const CameraPlace& camera);

/// To 0 to 1 over the whole picture (the display window), +x right, +y down, after the division by w, which
/// is the depth. The picture is `half_width` and `half_height` to each side on the plane at depth 1.
Matrix4 world_to_ndc(const CameraPlace& camera, double half_width, double half_height);

/// The camera's place from worldToCamera. Its axes are not of unit length where the matrix scales. Not finite
/// where the matrix has no inverse or is not finite.
CameraPlace camera_place(const Matrix4& world_to_camera);

/// View space as normals have it (right-handed, +z towards the viewer) to the world, row by row for points as
/// columns: M (x y z 1).
Matrix4 camera_to_world(const Matrix4& world_to_camera);

/// Where a point of the world is in NDC.
std::array<double, 2> project_to_ndc(const Matrix4& world_to_ndc, const std::array<double, 3>& point);

}  // namespace ld
