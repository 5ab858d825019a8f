#include "weights/released.h"

#include <set>

namespace ld {
namespace fs = std::filesystem;
namespace {

std::vector<fs::path> folders() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return {program.parent_path().parent_path() / "share" / "layer_denoiser" / "models", LD_MODELS};
}

}  // namespace

fs::path released_model(const std::string& name) {
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
