// Mappings and cameras of ld_import: YAML text, applied to a file of Blender.
#include "import/frame_import.h"
#include "tests/fuzz/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::filesystem::path text = ld::fuzz_file("input.yaml", data, size);
  static const std::filesystem::path picture =
      std::filesystem::path(LD_SOURCE_DIR) / "tests/fixtures/import/cycles/sample_00.exr";
  ld::expect_no_more_than_an_error(
      [&] { ld::import_frame({picture}, ld::read_mapping("", text, {}), std::nullopt, true); });
  ld::expect_no_more_than_an_error([&] {
    const ld::ViewCamera camera = ld::read_camera(text);
    ld::import_frame({picture}, ld::read_mapping("cycles", {}, {}), camera, true);
  });
  return 0;
}
