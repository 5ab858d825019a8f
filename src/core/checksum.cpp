#include "core/checksum.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <fstream>
#include <memory>
#include <vector>

#include "core/error.h"

namespace ld {

uint64_t checksum(const void* data, size_t bytes) {
  return XXH3_64bits(data, bytes);
}

std::string checksum_text(const void* data, size_t bytes) {
  return fmt::format("{:016x}", checksum(data, bytes));
}

std::string file_checksum(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    fail("cannot open {} to compute its checksum; check that it exists and is readable", path.string());
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_64bits_reset(state.get());
  std::vector<char> buffer(size_t{1} << 20);
  while (file) {
    file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    XXH3_64bits_update(state.get(), buffer.data(), static_cast<size_t>(file.gcount()));
  }
  if (file.bad()) fail("reading {} failed half-way; check the disk", path.string());
  return fmt::format("{:016x}", XXH3_64bits_digest(state.get()));
}

}  // namespace ld
