// Bytes that need not fit into memory, in a file without a name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace ld {

/// Lies on the disk of a folder, whose names it does not appear among: it is gone with the process, whatever
/// ends that. All throw Error with the system's reason.
class UnnamedFile {
 public:
  /// Makes the folder where it is missing; empty: the current one.
  explicit UnnamedFile(const std::filesystem::path& folder);
  ~UnnamedFile();
  UnnamedFile(const UnnamedFile&) = delete;
  UnnamedFile& operator=(const UnnamedFile&) = delete;

  void write(int64_t place, const void* data, size_t bytes);
  /// Of bytes that were written.
  void read(int64_t place, void* data, size_t bytes) const;

 private:
  std::filesystem::path folder_;
  int descriptor_;
};

}  // namespace ld
