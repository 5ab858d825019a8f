#include "weights/released.h"

#include <set>

namespace ld {
namespace fs = std::filesystem;
namespace {

fs::path& own_folder() {
  static fs::path folder;
  return folder;
}

std::vector<fs::path> folders() {
  if (!own_folder().empty()) return {own_folder()};
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return {program.parent_path().parent_path() / "share" / "layer_denoiser" / "models", LD_MODELS};
}

}  // namespace

void keep_released_models_in(const fs::path& folder) {
  own_folder() = folder;
}

fs::path released_model(const std::string& name) {
  if (name.empty() || fs::path(name).filename() != name) return {};
  std::error_code error;
  for (const fs::path& folder : folders())
    for (const char* size : {"", "_fine", "_fast"})
      if (fs::path file = folder / (name + size + ".safetensors"); fs::is_regular_file(file, error))
        return file;
  return {};
}

std::vector<std::string> released_models() {
  std::set<std::string> names;
  std::error_code error;
  for (const fs::path& folder : folders())
    for (const auto& entry : fs::directory_iterator(folder, error))
      if (entry.path().extension() == ".safetensors") names.insert(entry.path().stem().string());
  return {names.begin(), names.end()};
}

}  // namespace ld
