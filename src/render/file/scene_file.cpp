#include "render/file/scene_file.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/DefaultLogger.hpp>

#include <algorithm>
#include <assimp/Importer.hpp>

#include "core/error.h"
#include "core/shown_text.h"
#include "render/file/scene_file_materials.h"
#include "render/file/scene_file_nodes.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// Gives Assimp the file's bytes as read_gltf changed them; what the file refers to comes from the disk.
class PatchedFile : public Assimp::DefaultIOSystem {
 public:
  PatchedFile(std::string path, const std::string& bytes) : path_(std::move(path)), bytes_(bytes) {}

  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (path_ != file) return DefaultIOSystem::Open(file, mode);
    return new Assimp::MemoryIOStream(reinterpret_cast<const uint8_t*>(bytes_.data()), bytes_.size());
  }

 private:
  std::string path_;
  const std::string& bytes_;
};

const aiScene& import(Assimp::Importer& importer, const fs::path& path, const std::string& patched) {
  if (!fs::is_regular_file(path))
    fail("{}: no such file; expected a scene (glTF, OBJ, PLY, FBX...)", path.string());
  if (!patched.empty()) importer.SetIOHandler(new PatchedFile(path.string(), patched));  // Assimp deletes it
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(
      path.string(), aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_TransformUVCoords);
  if (scene == nullptr || scene->mRootNode == nullptr)
    fail("{}: cannot read the scene: {}; export it again", path.string(),
         one_line(importer.GetErrorString()));
  return *scene;
}

Vec3 to_vec3(const aiVector3D& v) {
  return {v.x, v.y, v.z};
}

bool finite(Vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// A mesh of the file in its own coordinates; without triangles where it holds points or lines only.
Mesh convert_mesh(const aiMesh& source, unsigned uv, const std::string& file) {
  Mesh mesh;
  for (unsigned i = 0; i < source.mNumVertices; ++i) {
    mesh.positions.push_back(to_vec3(source.mVertices[i]));
    if (!finite(mesh.positions.back()))
      fail("{}: mesh '{}' has a corner that is no number; export it again", file, source.mName.C_Str());
  }
  bool good_normals = source.HasNormals();
  for (unsigned i = 0; good_normals && i < source.mNumVertices; ++i) {
    mesh.normals.push_back(to_vec3(source.mNormals[i]));
    good_normals = finite(mesh.normals.back()) && dot(mesh.normals.back(), mesh.normals.back()) > 1e-12F;
  }
  if (!good_normals) mesh.normals.clear();  // flat then
  const unsigned channel = source.HasTextureCoords(uv) ? uv : 0;
  for (unsigned i = 0; source.HasTextureCoords(channel) && i < source.mNumVertices; ++i)
    mesh.uvs.push_back({source.mTextureCoords[channel][i].x, source.mTextureCoords[channel][i].y});
  for (unsigned f = 0; f < source.mNumFaces; ++f) {
    const aiFace& face = source.mFaces[f];
    if (face.mNumIndices != 3) continue;
    for (unsigned k = 0; k < 3; ++k)
      if (face.mIndices[k] >= source.mNumVertices)
        fail("{}: mesh '{}' refers to corner {} of {}; export it again", file, source.mName.C_Str(),
             face.mIndices[k], source.mNumVertices);
    mesh.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
  }
  return mesh;
}

Mesh transformed(const Mesh& source, const NodeMatrix& matrix) {
  Mesh mesh = source;
  for (Vec3& p : mesh.positions) p = transform_point(matrix, p);
  for (Vec3& n : mesh.normals) {
    n = transform_normal(matrix, n);
    const float size = length(n);
    n = size > 0 ? n / size : Vec3{0, 1, 0};  // a node scaled flat: the triangles have no area either
  }
  if (matrix.Determinant() < 0)  // mirrored: the outside stays outside
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

}  // namespace

struct SceneFile::Parts {
  struct View {
    GltfCamera optics;
    int node;
    Vec3 position, forward{0, 0, -1}, up{0, 1, 0};  // in the node's coordinates
  };
  struct Piece {
    size_t mesh;
    size_t node;
  };

  fs::path path;
  GltfFile gltf;
  std::unique_ptr<NodeTree> tree;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<int> mesh_materials;
  std::vector<Vec3> centres;  // of the meshes, in their own coordinates
  std::vector<Piece> pieces;
  std::vector<View> views;
  std::vector<GltfLight> lights;
  std::optional<Probe> probe;

  Parts(const fs::path& file, int64_t animation) : path(file) {
    if (is_gltf(file)) gltf = read_gltf(file);
    Assimp::Importer importer;
    const aiScene& scene = import(importer, file, gltf.bytes);
    tree = std::make_unique<NodeTree>(scene, static_cast<size_t>(animation));
    materials = read_materials(scene, file, gltf.materials);
    read_meshes(scene);
    read_cameras(scene);
    if (gltf.bytes.empty())
      read_lights(scene);
    else
      lights = gltf.lights;
    if (gltf.probe) probe = read_probe(gltf.probe->path, gltf.probe->scale, gltf.probe->turn);
    gltf.bytes.clear();
  }

  void read_meshes(const aiScene& scene) {
    for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
      const aiMesh& source = *scene.mMeshes[i];
      if (source.mMaterialIndex >= materials.size())
        fail("{}: mesh '{}' has no material; export it again", path.string(), source.mName.C_Str());
      const unsigned uv = uv_channel(*scene.mMaterials[source.mMaterialIndex]);
      meshes.push_back(convert_mesh(source, uv, path.string()));
      mesh_materials.push_back(static_cast<int>(source.mMaterialIndex));
      centres.push_back(meshes.back().positions.empty() ? Vec3{}
                                                        : bounds_of(meshes.back().positions).centre());
    }
    const auto& nodes = tree->nodes();
    for (size_t n = 0; n < nodes.size(); ++n)
      for (const unsigned mesh : nodes[n].meshes)
        if (mesh < meshes.size() && !meshes[mesh].triangles.empty()) pieces.push_back({mesh, n});
    if (pieces.empty())
      fail("{}: no triangles in the scene; expected meshes (points and lines are not drawn)", path.string());
  }

  void read_cameras(const aiScene& scene) {
    for (const GltfCamera& camera : gltf.cameras) add_view({camera, tree->find(camera.node), {}});
    if (!gltf.cameras.empty()) return;
    for (unsigned i = 0; i < scene.mNumCameras && !is_gltf(path); ++i) {
      const aiCamera& source = *scene.mCameras[i];
      GltfCamera optics;
      optics.name = source.mName.C_Str();
      const float aspect = source.mAspect > 0 ? source.mAspect : 1;
      optics.fov = 2 * std::atan(std::tan(0.5F * source.mHorizontalFOV) / aspect);
      if (!(optics.fov > 0.01F && optics.fov < 3)) continue;  // orthographic ones come as 0
      View view = {optics, tree->find(optics.name), to_vec3(source.mPosition)};
      view.forward = to_vec3(source.mLookAt);
      view.up = to_vec3(source.mUp);
      add_view(view);
    }
  }

  /// A node that belongs to no scene of the file has no place in the world.
  void add_view(const View& view) {
    if (view.node >= 0) views.push_back(view);
  }

  void read_lights(const aiScene& scene) {
    for (unsigned i = 0; i < scene.mNumLights; ++i) {
      const aiLight& source = *scene.mLights[i];
      GltfLight light;
      light.node = source.mName.C_Str();
      light.intensity = {source.mColorDiffuse.r, source.mColorDiffuse.g, source.mColorDiffuse.b};
      if (source.mType == aiLightSource_DIRECTIONAL)
        light.kind = GltfLightKind::directional;
      else if (source.mType == aiLightSource_SPOT)
        light.kind = GltfLightKind::spot;
      else if (source.mType != aiLightSource_POINT)
        continue;
      light.inner = 0.5F * source.mAngleInnerCone;  // Assimp's are whole angles
      light.outer = 0.5F * source.mAngleOuterCone;
      lights.push_back(light);
    }
  }

  static CameraPose pose(const View& view, const std::vector<NodeMatrix>& world) {
    const NodeMatrix& matrix = world[static_cast<size_t>(view.node)];
    const Vec3 position = transform_point(matrix, view.position);
    const Vec3 forward = transform_vector(matrix, view.forward), up = transform_vector(matrix, view.up);
    if (!(length(forward) > 0) || !(length(cross(forward, up)) > 0))
      fail("camera '{}' has a node without extent; give it a scale above 0", view.optics.name);
    Basis axes;
    axes.z = -normalize(forward);
    axes.x = normalize(cross(up, axes.z));
    axes.y = cross(axes.z, axes.x);
    return {position, axes};
  }

  void place_light(const GltfLight& light, const std::vector<NodeMatrix>& world, Scene& scene) const {
    const int node = tree->find(light.node);
    if (node < 0 || is_black(light.intensity)) return;
    const NodeMatrix& matrix = world[static_cast<size_t>(node)];
    const Vec3 along = transform_vector(matrix, {0, 0, -1});
    if (light.kind == GltfLightKind::directional) {
      scene.directional_lights.push_back({-normalize(along), light.intensity});
      return;
    }
    PointLight lamp;
    lamp.position = transform_point(matrix, {});
    lamp.intensity = light.intensity;
    if (light.kind == GltfLightKind::spot) {
      lamp.direction = normalize(along);
      lamp.cos_outer = std::cos(light.outer);
      lamp.cos_inner = std::max(std::cos(light.inner), lamp.cos_outer);
    }
    scene.point_lights.push_back(lamp);
  }
};

SceneFile::SceneFile(const fs::path& path, int64_t animation)
    : parts_(std::make_unique<const Parts>(path, animation)) {}
SceneFile::~SceneFile() = default;

const fs::path& SceneFile::path() const {
  return parts_->path;
}

double SceneFile::duration() const {
  return parts_->tree->duration();
}

bool SceneFile::has_light() const {
  if (parts_->probe || !parts_->lights.empty()) return true;
  return std::any_of(parts_->pieces.begin(), parts_->pieces.end(), [this](const Parts::Piece& piece) {
    return parts_->materials[static_cast<size_t>(parts_->mesh_materials[piece.mesh])].emission.has_value();
  });
}

Bounds SceneFile::bounds(double seconds) const {
  const auto world = parts_->tree->world(seconds);
  std::vector<Vec3> corners;
  for (const Parts::Piece& piece : parts_->pieces) {
    std::vector<Vec3> positions;
    for (const Vec3 p : parts_->meshes[piece.mesh].positions)
      positions.push_back(transform_point(world[piece.node], p));
    const Bounds own = bounds_of(positions);
    corners.push_back(own.low);
    corners.push_back(own.high);
  }
  return bounds_of(corners);
}

size_t SceneFile::camera_count() const {
  return parts_->views.size();
}

const std::string& SceneFile::camera_name(size_t index) const {
  return parts_->views.at(index).optics.name;
}

bool SceneFile::camera_moves(size_t index) const {
  for (int node = parts_->views.at(index).node; node >= 0;) {
    const NodeTree::Node& own = parts_->tree->nodes()[static_cast<size_t>(node)];
    if (own.track >= 0) return true;
    node = own.parent;
  }
  return false;
}

Camera SceneFile::camera(size_t index, const FrameTimes& times) const {
  const Parts::View& view = parts_->views.at(index);
  Camera camera;
  const CameraPose open = Parts::pose(view, parts_->tree->world(times.open));
  camera.position = open.position;
  camera.axes = open.axes;
  camera.fov = view.optics.fov;
  camera.lens_radius = view.optics.lens_radius;
  camera.focus_distance = view.optics.focus_distance;
  camera.shutter = times.close > times.open;
  if (!camera_moves(index)) return camera;
  if (camera.shutter) camera.close = Parts::pose(view, parts_->tree->world(times.close));
  camera.previous = Parts::pose(view, parts_->tree->world(times.previous));
  return camera;
}

Scene SceneFile::scene(const FrameTimes& times) const {
  const NodeTree& tree = *parts_->tree;
  const auto open = tree.world(times.open), close = tree.world(times.close),
             previous = tree.world(times.previous);
  Scene scene;
  scene.name = parts_->path.filename().string();
  scene.materials = parts_->materials;
  for (const Parts::Piece& piece : parts_->pieces) {
    Object object;
    object.mesh = transformed(parts_->meshes[piece.mesh], open[piece.node]);
    object.material = parts_->mesh_materials[piece.mesh];
    const Vec3 centre = parts_->centres[piece.mesh];
    object.motion = rigid_motion(open[piece.node], close[piece.node], centre);
    object.previous = rigid_motion(open[piece.node], previous[piece.node], centre);
    scene.objects.push_back(std::move(object));
  }
  for (const GltfLight& light : parts_->lights) parts_->place_light(light, open, scene);
  scene.probe = parts_->probe;
  return scene;
}

Probe read_probe(const fs::path& path, Vec3 scale, float turn) {
  Probe probe;
  probe.image = read_texture_image(path, TextureUse::colour);
  probe.scale = scale;
  probe.orientation.x = rotate(probe.orientation.x, {0, 1, 0}, turn);
  probe.orientation.z = rotate(probe.orientation.z, {0, 1, 0}, turn);
  return probe;
}

}  // namespace ld
