// What the fuzz targets share: the bytes as a file, and that a complaint is an Error of one line which names
// it.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/error.h"
#include "core/file_io.h"

namespace ld {

/// In memory, one for each process; the same path for every input.
inline std::filesystem::path fuzz_folder() {
  static const std::filesystem::path folder = [] {
    const std::filesystem::path made = "/dev/shm/ld_fuzz_" + std::to_string(getpid());
    std::filesystem::create_directories(made);
    return made;
  }();
  return folder;
}

inline std::filesystem::path fuzz_file(const std::string& name, const uint8_t* data, size_t size) {
  const std::filesystem::path path = fuzz_folder() / name;
  write_file_atomically(path, std::string(reinterpret_cast<const char*>(data), size));
  return path;
}

/// Anything but an Error, and one that is not a single line, ends the process: the fuzzer keeps the input.
template <class Action>
void expect_no_more_than_an_error(Action action) {
  try {
    action();
  } catch (const Error& error) {
    if (std::string(error.what()).find('\n') != std::string::npos) std::abort();
  }
}

}  // namespace ld
