// Manifests of data sets.
#include "frame/manifest.h"
#include "tests/fuzz/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  ld::fuzz_file("manifest.json", data, size);
  ld::expect_no_more_than_an_error([&] { ld::read_manifest(ld::fuzz_folder()); });
  return 0;
}
