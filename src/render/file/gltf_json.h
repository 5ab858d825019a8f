// What Assimp 5.2 loses of a glTF 2.0 file, read from its JSON: cameras and lights with their nodes, emissive
// strength, and the project's own `extras`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/trace/scene.h"

namespace ld {

struct GltfCamera {
  std::string name;
  std::string node;                           // as Assimp names it, see GltfFile::bytes
  float fov = 0.8F;                           // vertical, radians
  float lens_radius = 0, focus_distance = 1;  // scene units; of extras.ld {aperture_radius, focus_distance}
};

enum class GltfLightKind { point, spot, directional };

/// KHR_lights_punctual; it shines along -z of its node. The numbers are taken as W/sr and W/m^2 as they
/// stand, and `range` is ignored, as Blender does unless told otherwise.
struct GltfLight {
  std::string node;
  GltfLightKind kind = GltfLightKind::point;
  Vec3 intensity;                      // colour times intensity; of a directional light the irradiance
  float inner = 0, outer = 0.785398F;  // half angles of a spot's cones, radians
};

struct GltfMaterial {
  std::string name;
  float emissive_strength = 1;  // KHR_materials_emissive_strength
  // extras.ld {kind, roughness, ior, eta, k}
  std::optional<MaterialKind> kind;
  std::optional<float> roughness, ior;
  std::optional<Vec3> eta, k;
};

struct GltfProbe {
  std::filesystem::path path;
  Vec3 scale = {1, 1, 1};
  float turn = 0;  // radians counter-clockwise as seen from +y
};

struct GltfFile {
  /// The file with names that Assimp keeps apart: node i is "nodes[i]", material i "materials[i]". Names in
  /// files need be neither there nor unique.
  std::string bytes;
  std::vector<GltfCamera> cameras;  // perspective ones that a node has, in the order of the nodes
  std::vector<GltfLight> lights;
  std::vector<GltfMaterial> materials;
  std::vector<std::filesystem::path> files;  // buffers and pictures that lie outside the file
  std::optional<GltfProbe> probe;            // scenes[].extras.ld.probe {uri, scale, rotation_y}
};

/// "my%20picture.png" as it stands in URIs.
std::string percent_decoded(const std::string& uri);

/// Whether this is a glTF 2.0 file by its name; older glTF is left to Assimp.
bool is_gltf(const std::filesystem::path& path);

/// Throws Error with one line: missing, truncated, not JSON, entries of the wrong kind, indices that lead
/// nowhere.
GltfFile read_gltf(const std::filesystem::path& path);

}  // namespace ld
