// XXH3 (64 bit) checksums of memory and files, as 16 hexadecimal digits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace ld {

uint64_t checksum(const void* data, size_t bytes);
std::string checksum_text(const void* data, size_t bytes);

/// Throws Error when the file cannot be read.
std::string file_checksum(const std::filesystem::path& path);

}  // namespace ld
