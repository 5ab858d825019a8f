#include "render/file/scene_file_config.h"

#include "core/checksum.h"
#include "core/error.h"
#include "render/file/gltf_json.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

std::string found_from(const fs::path& folder, const std::string& path) {
  return path.empty() || fs::path(path).is_absolute() ? path : (folder / path).lexically_normal().string();
}

}  // namespace

void resolve(SceneFileConfig& config, const fs::path& folder) {
  if (!config.used()) return;
  config.path = found_from(folder, config.path);
  config.probe = found_from(folder, config.probe);
  std::vector<fs::path> files = {config.path};
  if (is_gltf(config.path)) {
    const GltfFile gltf = read_gltf(config.path);
    files.insert(files.end(), gltf.files.begin(), gltf.files.end());
    if (gltf.probe && config.probe.empty()) files.push_back(gltf.probe->path);
  }
  if (!config.probe.empty()) files.emplace_back(config.probe);
  std::string all;
  for (const fs::path& file : files) {
    if (!fs::is_regular_file(file))
      fail("{}: no such file{}", file.string(),
           file == files[0] ? "; expected a scene (glTF, OBJ, PLY, FBX...)"
                            : "; " + config.path + " refers to it");
    all += file_checksum(file);
  }
  const std::string found = files.size() == 1 ? all : checksum_text(all.data(), all.size());
  if (!config.checksum.empty() && config.checksum != found)
    fail_usage("{}: checksum {}; the recipe says {}: the file, or one that it refers to, was changed",
               config.path, found, config.checksum);
  config.checksum = found;
}

}  // namespace ld
