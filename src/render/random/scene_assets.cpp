#include "render/random/scene_assets.h"

#include <algorithm>
#include <cctype>
#include <tuple>

#include "core/checksum.h"
#include "core/error.h"
#include "render/geometry/mesh_file.h"

namespace ld {
namespace {

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Whether a mesh encloses a volume, so that it may be of glass: every edge between two places runs both
/// ways.
bool is_closed(const Mesh& mesh) {
  using Place = std::tuple<float, float, float>;
  std::vector<Place> sorted;
  const auto place_of = [](Vec3 p) { return Place{p.x + 0.0F, p.y + 0.0F, p.z + 0.0F}; };
  for (const Vec3 p : mesh.positions) sorted.push_back(place_of(p));
  std::sort(sorted.begin(), sorted.end());
  const auto index = [&](uint32_t i) {
    return std::lower_bound(sorted.begin(), sorted.end(), place_of(mesh.positions[i])) - sorted.begin();
  };
  std::vector<std::tuple<std::ptrdiff_t, std::ptrdiff_t, bool>> edges;
  for (const auto& t : mesh.triangles)
    for (size_t k = 0; k < 3; ++k) {
      const auto a = index(t[k]), b = index(t[(k + 1) % 3]);
      edges.emplace_back(std::min(a, b), std::max(a, b), a < b);
    }
  std::sort(edges.begin(), edges.end());
  for (size_t i = 0; i < edges.size();) {
    const auto [a, b, first] = edges[i];
    int balance = 0;
    for (; i < edges.size() && std::get<0>(edges[i]) == a && std::get<1>(edges[i]) == b; ++i)
      balance += std::get<2>(edges[i]) ? 1 : -1;
    if (balance != 0) return false;
  }
  return true;
}

}  // namespace

template <class T>
std::vector<SceneAssets::File<T>> SceneAssets::list(const std::string& folder, const char* what,
                                                    const std::vector<std::string>& suffixes) {
  std::vector<File<T>> files;
  if (folder.empty()) return files;
  if (!std::filesystem::is_directory(folder))
    fail("scenes.{}: {}: no such folder; expected one with {}", what, folder, fmt::join(suffixes, ", "));
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string suffix = lower(entry.path().extension().string());
    if (!entry.is_regular_file() || std::find(suffixes.begin(), suffixes.end(), suffix) == suffixes.end())
      continue;
    files.push_back({entry.path(), entry.path().lexically_relative(folder).generic_string(), nullptr});
  }
  if (files.empty())
    fail("scenes.{}: {}: expected files with {}, found none", what, folder, fmt::join(suffixes, ", "));
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return files;
}

SceneAssets::SceneAssets(const std::string& meshes, const std::string& textures, const std::string& probes)
    : meshes_(list<Mesh>(meshes, "meshes", {".obj", ".ply", ".gltf", ".glb", ".stl", ".off"})),
      textures_(list<TextureImage>(
          textures, "textures", {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr", ".webp", ".bmp", ".tga"})),
      probes_(list<TextureImage>(probes, "probes", {".hdr", ".exr"})) {}

Model SceneAssets::model(RandomStream& random) const {
  const File<Mesh>& file = meshes_[random.below(static_cast<uint32_t>(meshes_.size()))];
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!file.content) file.content = std::make_shared<const Mesh>(read_mesh(file.path));
  Model model;
  model.push_back({*file.content, Stuff::any, is_closed(*file.content)});
  return model;
}

std::shared_ptr<const TextureImage> SceneAssets::texture(RandomStream& random) const {
  const File<TextureImage>& file = textures_[random.below(static_cast<uint32_t>(textures_.size()))];
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!file.content) file.content = read_texture_image(file.path, TextureUse::colour);
  return file.content;
}

std::shared_ptr<const TextureImage> SceneAssets::probe(RandomStream& random) const {
  const File<TextureImage>& file = probes_[random.below(static_cast<uint32_t>(probes_.size()))];
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!file.content) file.content = read_texture_image(file.path, TextureUse::colour);
  return file.content;
}

std::string SceneAssets::checksum() const {
  std::string all;
  const auto add = [&](const auto& files, const char* what) {
    for (const auto& file : files)
      all += fmt::format("{} {} {}\n", what, file.name, file_checksum(file.path));
  };
  add(meshes_, "mesh");
  add(textures_, "texture");
  add(probes_, "probe");
  return all.empty() ? "" : checksum_text(all.data(), all.size());
}

std::shared_ptr<const SceneAssets> shared_assets(const std::string& meshes, const std::string& textures,
                                                 const std::string& probes) {
  static std::mutex mutex;
  static std::vector<
      std::pair<std::tuple<std::string, std::string, std::string>, std::shared_ptr<const SceneAssets>>>
      all;
  const std::lock_guard<std::mutex> lock(mutex);
  const auto key = std::make_tuple(meshes, textures, probes);
  for (const auto& [folders, assets] : all)
    if (folders == key) return assets;
  all.emplace_back(key, std::make_shared<const SceneAssets>(meshes, textures, probes));
  return all.back().second;
}

}  // namespace ld
