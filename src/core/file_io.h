// Whole files in and out. What is written appears under its name only when complete: beside, flushed,
// renamed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace ld {

/// The file's bytes. Throws Error when it is missing, unreadable or larger than `limit` bytes.
std::string read_file(const std::filesystem::path& path, uint64_t limit = uint64_t{1} << 30);

/// Calls write(temporary path in the same folder), flushes that file to disk and renames it to `path`. When
/// `write` throws, the temporary file is removed and an existing `path` stays as it was. Makes missing parent
/// folders. Throws Error with the system's reason where no file can be made there.
void write_atomically(const std::filesystem::path& path,
                      const std::function<void(const std::filesystem::path&)>& write);
void write_file_atomically(const std::filesystem::path& path, const std::string& bytes);

/// Throws Error: `path` cannot be written, for the reason that a library or the system (strerror) gives.
[[noreturn]] void fail_to_write(const std::filesystem::path& path, const std::string& reason);

/// Flushes a file's or a folder's data to the disk. Throws Error when that fails.
void flush_to_disk(const std::filesystem::path& path);

/// Makes the folder and its parents. Throws Error when that fails.
void make_folder(const std::filesystem::path& path);

/// An exclusive lock between processes on `path` (made if missing), held until the object dies.
class FileLock {
 public:
  explicit FileLock(const std::filesystem::path& path);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace ld
