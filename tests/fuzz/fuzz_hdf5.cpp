// HDF5 files of samples, with a good file of references beside them.
#include "import/hdf5_layout.h"
#include "tests/fuzz/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::filesystem::path path = ld::fuzz_file("input.h5", data, size);
  const std::filesystem::path set = ld::fuzz_folder() / "set";
  ld::expect_no_more_than_an_error(
      [&] { ld::data_set_from_hdf5(path, path, set, "a", "train", ld::Hdf5Depth::linear); });
  std::filesystem::remove_all(set);
  return 0;
}
