// glTF scenes, text and binary: what this project reads of them itself, and Assimp the rest.
#include "render/file/scene_file.h"
#include "tests/fuzz/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::filesystem::path path =
      ld::fuzz_file(size > 3 && data[0] == 'g' ? "input.glb" : "input.gltf", data, size);
  ld::expect_no_more_than_an_error([&] {
    const ld::SceneFile file(path);
    if (file.camera_count() > 0) file.camera(0, {});
    file.scene({});
  });
  return 0;
}
