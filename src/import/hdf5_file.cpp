#include "import/hdf5_file.h"

#include "core/module.h"

namespace ld {

const Hdf5Library& hdf5_library() {
  static const auto* const library = static_cast<const Hdf5Library*>(
      load_module("ld_hdf5", "reads and writes HDF5 files",
                  "install the program again; if it was built without HDF5, install libhdf5-dev and run "
                  "scripts/setup.sh and cmake --build --preset release"));
  return *library;
}

std::unique_ptr<Hdf5File> Hdf5File::open(const std::filesystem::path& path) {
  return hdf5_library().open(path);
}

std::unique_ptr<Hdf5File> Hdf5File::create(const std::filesystem::path& path) {
  return hdf5_library().create(path);
}

}  // namespace ld
