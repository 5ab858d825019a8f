// What a program that was built without HDF5 says.
#include "core/error.h"
#include "import/hdf5_layout.h"

namespace ld {
namespace {

[[noreturn]] void fail_missing() {
  fail("this program was built without HDF5; install libhdf5-dev and run scripts/setup.sh again");
}

}  // namespace

void require_no_fault_in_hdf5(const std::filesystem::path&, const std::filesystem::path&) {
  fail_missing();
}

Hdf5Report data_set_from_hdf5(const std::filesystem::path&, const std::filesystem::path&,
                              const std::filesystem::path&, const std::string&, const std::string&,
                              Hdf5Depth) {
  fail_missing();
}

Hdf5Report data_set_to_hdf5(const std::filesystem::path&, const std::string&, const std::filesystem::path&,
                            const std::filesystem::path&) {
  fail_missing();
}

}  // namespace ld
