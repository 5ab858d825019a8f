// What a checkpoint says of its training. What is accepted is written and read again to the same text.
#include "training/run/training_state.h"

#include "tests/fuzz/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  ld::expect_no_more_than_an_error([&] {
    const std::string text(reinterpret_cast<const char*>(data), size);
    const std::string written = ld::state_to_json(ld::state_from_json(text, "state.json"));
    if (ld::state_to_json(ld::state_from_json(written, "state.json")) != written) std::abort();
  });
  return 0;
}
