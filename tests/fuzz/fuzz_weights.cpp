// Weight files: the safetensors header, the metadata with the network's configuration, every byte of every
// tensor.
#include "tests/fuzz/fuzz_file.h"
#include "weights/weight_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::filesystem::path path = ld::fuzz_file("input.safetensors", data, size);
  ld::expect_no_more_than_an_error([&] {
    const ld::SafetensorsFile file(path);
    volatile uint64_t sum = 0;
    for (const ld::TensorView& tensor : file.tensors())
      for (size_t i = 0; i < tensor.bytes; ++i) sum = sum + static_cast<const uint8_t*>(tensor.data)[i];
    ld::read_weights_header(file);
  });
  return 0;
}
