// Frames, pictures and other renderers' files, raw bytes: headers, samples, references, recognised layouts.
#include "frame/frame_file.h"
#include "frame/picture_place.h"
#include "import/frame_import.h"
#include "import/recognise.h"
#include "tests/fuzz/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::filesystem::path path = ld::fuzz_file("input.exr", data, size);
  ld::expect_no_more_than_an_error([&] { ld::read_frame_header(path); });
  ld::expect_no_more_than_an_error([&] {
    ld::Faults faults;
    ld::read_frame(path, {"radiance"}, faults);
  });
  ld::expect_no_more_than_an_error([&] {
    const ld::PicturePlace place = ld::read_place(path);
    ld::read_reference(path, place, "the frame");
  });
  ld::expect_no_more_than_an_error([&] {
    const std::string preset = ld::recognise_preset(ld::ExrReader(path));
    ld::import_frame({path}, ld::read_mapping(preset, {}, {"normal.channels=[]", "depth.channels=[]"}), {},
                     true);
  });
  return 0;
}
