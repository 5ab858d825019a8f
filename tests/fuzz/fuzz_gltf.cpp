// glTF scenes, text and binary.
#include "render/gltf_json.h"
#include "tests/fuzz/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::filesystem::path path = ld::fuzz_file(size > 3 && data[0] == 'g' ? "input.glb" : "input.gltf", data, size);
  ld::expect_no_more_than_an_error([&] { ld::read_gltf(path); });
  return 0;
}
