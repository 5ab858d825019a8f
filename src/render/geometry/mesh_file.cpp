#include "render/geometry/mesh_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>

#include "core/error.h"
#include "render/geometry/mesh_tools.h"

namespace ld {
namespace {

Mesh mesh_of(const aiMesh& from) {
  Mesh mesh;
  for (unsigned i = 0; i < from.mNumVertices; ++i) {
    const aiVector3D& p = from.mVertices[i];
    mesh.positions.push_back({p.x, p.y, p.z});
    if (from.HasTextureCoords(0))
      mesh.uvs.push_back({from.mTextureCoords[0][i].x, from.mTextureCoords[0][i].y});
    if (!from.HasNormals()) continue;
    const Vec3 n = {from.mNormals[i].x, from.mNormals[i].y, from.mNormals[i].z};
    const float size = length(n);
    mesh.normals.push_back(size > 0 && std::isfinite(size) ? n / size : Vec3{0, 1, 0});
  }
  for (unsigned i = 0; i < from.mNumFaces; ++i) {
    const aiFace& face = from.mFaces[i];
    if (face.mNumIndices == 3)
      mesh.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
  }
  if (mesh.normals.empty()) shade(mesh, 0.7F);
  return mesh;
}

}  // namespace

Mesh read_mesh(const std::filesystem::path& path) {
  constexpr size_t kMost = 10'000'000;
  if (!std::filesystem::is_regular_file(path)) fail("{}: no such file; expected a mesh", path.string());
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(
      path.string(), aiProcess_Triangulate | aiProcess_JoinIdenticalVertices | aiProcess_SortByPType |
                         aiProcess_PreTransformVertices | aiProcess_ValidateDataStructure);
  if (scene == nullptr) fail("{}: cannot be read as a mesh: {}", path.string(), importer.GetErrorString());
  Mesh mesh;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
    const aiMesh& part = *scene->mMeshes[i];
    if (mesh.triangles.size() + part.mNumFaces > kMost)
      fail("{}: expected at most {} triangles, found more; simplify it", path.string(), kMost);
    Mesh read = mesh_of(part);
    if (!read.triangles.empty()) append(mesh, std::move(read));
  }
  if (mesh.triangles.empty()) fail("{}: expected triangles, found none", path.string());
  for (const Vec3 p : mesh.positions)
    if (!std::isfinite(p.x + p.y + p.z)) fail("{}: a position is not a number", path.string());
  const Vec3 centre = bounds_of(mesh.positions).centre();
  const float radius = radius_around(mesh.positions, centre);
  if (!(radius > 0)) fail("{}: all positions are in one place", path.string());
  place(mesh, grey(1 / radius), {}, centre * (-1 / radius));
  return mesh;
}

}  // namespace ld
