// A scene that somebody else made, as a file: glTF 2.0 in full as far as the renderer goes, and whatever else
// Assimp reads (OBJ, PLY, FBX, COLLADA...) as far as that goes.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "render/geometry/mesh_tools.h"
#include "render/trace/scene.h"

namespace ld {

/// Where a frame lies in the file's animation, seconds.
struct FrameTimes {
  double open = 0, close = 0;  // of the shutter; equal: an instant
  double previous = 0;         // shutter open of the frame before
};

class SceneFile {
 public:
  /// `animation` is an index into the file's; none is used where the file has fewer. Throws Error with one
  /// line: missing, not a scene, damaged, a texture that is not there, positions that are no numbers, nothing
  /// to see.
  explicit SceneFile(const std::filesystem::path& path, int64_t animation = 0);
  ~SceneFile();

  const std::filesystem::path& path() const;
  /// Of the animation, seconds; 0 without one.
  double duration() const;
  /// A surface, a lamp or a probe of the file shines.
  bool has_light() const;
  /// Of all objects at this time.
  Bounds bounds(double seconds) const;

  /// Perspective cameras, each node's on its own.
  size_t camera_count() const;
  const std::string& camera_name(size_t index) const;
  bool camera_moves(size_t index) const;
  /// Pose, field of view and lens; poses at shutter close and in the previous frame where the camera moves.
  /// Width and height are the caller's.
  Camera camera(size_t index, const FrameTimes& times) const;

  /// Objects with their motion, materials, lights and the file's probe; no camera and no sky. A node's
  /// animation is taken as a rigid motion from shutter open to shutter close; skins and morph targets stay in
  /// their rest pose.
  Scene scene(const FrameTimes& times) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

/// The environment turned by `turn` radians counter-clockwise as seen from +y.
Probe read_probe(const std::filesystem::path& path, Vec3 scale, float turn);

}  // namespace ld
