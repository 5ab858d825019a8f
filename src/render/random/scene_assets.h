// The user's own meshes, textures and probes, for random scenes to draw from.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/random.h"
#include "render/random/shapes/model.h"
#include "render/shading/texture_image.h"

namespace ld {

/// Files of up to three folders and the folders below them, in the order of their relative names, whatever
/// the file system's. Files are read when first asked for and kept; safe to use from several threads.
class SceneAssets {
 public:
  /// Empty folder names: none of that kind. Throws Error for a folder that is missing or holds nothing
  /// usable.
  SceneAssets(const std::string& meshes, const std::string& textures, const std::string& probes);

  bool has_meshes() const { return !meshes_.empty(); }
  bool has_textures() const { return !textures_.empty(); }
  bool has_probes() const { return !probes_.empty(); }

  /// Throw Error when a file cannot be read, with its name.
  Model model(RandomStream& random) const;
  std::shared_ptr<const TextureImage> texture(RandomStream& random) const;
  std::shared_ptr<const TextureImage> probe(RandomStream& random) const;

  /// Over the names and bytes of all files; "" without any.
  std::string checksum() const;

 private:
  template <class T>
  struct File {
    std::filesystem::path path;
    std::string name;  // below its folder, with '/'
    mutable std::shared_ptr<const T> content;
  };
  template <class T>
  static std::vector<File<T>> list(const std::string& folder, const char* what,
                                   const std::vector<std::string>& suffixes);

  std::vector<File<Mesh>> meshes_;
  std::vector<File<TextureImage>> textures_, probes_;
  mutable std::mutex mutex_;
};

/// The assets of these folders, shared by all scenes of the process.
std::shared_ptr<const SceneAssets> shared_assets(const std::string& meshes, const std::string& textures,
                                                 const std::string& probes);

}  // namespace ld
