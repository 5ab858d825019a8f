// Meshes from files.
#pragma once

#include <filesystem>

#include "render/geometry/mesh.h"

namespace ld {

/// All triangles of an OBJ, PLY, glTF, STL or other file that Assimp reads, as one mesh: its middle in the
/// origin, of unit radius; normals as in the file, else smooth up to 40 degrees; texture coordinates where
/// all parts have them. Materials are left behind. Throws Error: missing, not a mesh, without triangles, more
/// than ten million triangles.
Mesh read_mesh(const std::filesystem::path& path);

}  // namespace ld
