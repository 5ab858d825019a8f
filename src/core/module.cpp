#include "core/module.h"

#include <dlfcn.h>

#include <filesystem>

#include "core/error.h"

namespace ld {
namespace fs = std::filesystem;

const void* load_module(const std::string& name, const std::string& use, const std::string& remedy) {
  std::error_code error;
  // The program itself, not a link to it; where this is not known, the folder is that of the package.
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path folder = (error ? fs::path("/usr/bin") : program.parent_path()) / LD_MODULE_FOLDER;
  const std::string path = (folder.lexically_normal() / ("lib" + name + ".so")).string();
  const auto refuse = [&](const std::string& found) {
    fail("cannot load {}, which {}: {}; expected it where the program was built or installed: {}", path, use,
         found, remedy);
  };
  if (!fs::exists(path, error)) refuse("no such file");
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) refuse(dlerror());
  void* const function = dlsym(library, "ld_module");
  if (function == nullptr) refuse("it is of another version or no module");
  return reinterpret_cast<const void* (*)()>(function)();
}

}  // namespace ld
