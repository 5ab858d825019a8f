#include "core/file_io.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <vector>

#include "core/checksum.h"
#include "core/error.h"
#include "core/file_identity.h"
#include "core/unique_name.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

/// Removes a half-written file unless it was renamed in time.
class TemporaryFile {
 public:
  explicit TemporaryFile(fs::path path) : path_(std::move(path)) {}
  ~TemporaryFile() {
    std::error_code ignored;  // the destructor also runs after success, when the file is gone
    fs::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

std::string read_file(const fs::path& path, uint64_t limit) {
  std::error_code error;
  if (!fs::exists(path, error)) fail("no such file: {}; check the path", path.string());
  if (is_special(path)) fail("{} is no regular file; expected one that can be read again", path.string());
  if (fs::is_directory(path, error)) fail("{} is a folder; expected a file", path.string());
  const auto size = fs::file_size(path, error);
  if (error) fail("cannot read {}: {}", path.string(), error.message());
  if (size > limit)
    fail("{} has {} bytes; expected at most {}; is it the right kind of file?", path.string(), size, limit);
  std::ifstream file(path, std::ios::binary);
  std::string bytes(size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!file || static_cast<uint64_t>(file.gcount()) != size)
    fail("cannot read {} whole: {}", path.string(), std::strerror(errno));
  return bytes;
}

void fail_to_write(const fs::path& path, const std::string& reason) {
  fail("cannot write {}: {}", path.string(), reason);
}

void flush_to_disk(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) fail("cannot open {} to flush it: {}", path.string(), std::strerror(errno));
  const bool flushed = fsync(descriptor) == 0;
  const int reason = errno;
  close(descriptor);
  if (!flushed) fail("cannot flush {}: {}", path.string(), std::strerror(reason));
}

void make_folder(const fs::path& path) {
  std::error_code error;
  std::vector<fs::path> missing;  // the deepest one first
  for (fs::path folder = path; !folder.empty() && !fs::exists(folder, error); folder = folder.parent_path())
    missing.push_back(folder);
  fs::create_directories(path, error);
  if (error || !fs::is_directory(path))
    fail("cannot make the folder {}: {}; check the path and its permissions", path.string(),
         error ? error.message() : "a file of that name exists");
  // A power cut may take a folder whose name is not on the disk, with all that was flushed in it. A parent
  // that may be written but not read cannot be flushed.
  for (auto folder = missing.rbegin(); folder != missing.rend(); ++folder) {
    const fs::path parent = folder->has_parent_path() ? folder->parent_path() : fs::path(".");
    if (access(parent.c_str(), R_OK) == 0) flush_to_disk(parent);
  }
}

void write_atomically(const fs::path& named, const std::function<void(const fs::path&)>& write) {
  std::error_code ignored;
  const fs::path path =
      fs::is_symlink(named, ignored) && fs::exists(named, ignored) ? fs::canonical(named) : named;
  if (is_special(path))
    fail("cannot write {}: neither a file nor the name of a new one, and renaming over it would remove it",
         named.string());
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  make_folder(folder);
  // The extension stays last, because image libraries choose the format by it. The name is short, because the
  // file's own may be as long as the system allows.
  const std::string name = path.filename().string();
  const TemporaryFile temporary(folder / fmt::format(".{:016x}.{}.partial{}",
                                                     checksum(name.data(), name.size()), unique_name(),
                                                     path.extension().string()));
  // Whatever writes the file may not know why it cannot: the system does.
  struct stat there {};
  if (lstat(path.c_str(), &there) != 0 && errno != ENOENT) fail_to_write(path, std::strerror(errno));
  const int descriptor = open(temporary.path().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) fail_to_write(path, std::strerror(errno));
  close(descriptor);
  write(temporary.path());
  flush_to_disk(temporary.path());
  std::error_code error;
  fs::rename(temporary.path(), path, error);
  if (error) fail("cannot rename {} to {}: {}", temporary.path().string(), path.string(), error.message());
  flush_to_disk(folder);
}

void write_file_atomically(const fs::path& path, const std::string& bytes) {
  // A pipe or /dev/null; and standard output, which may be a file that others write to, too.
  if (is_special(path) || path == "/dev/stdout" || path == "/dev/stderr") {
    std::ofstream file(path, std::ios::binary);
    file << bytes << std::flush;
    if (!file) fail_to_write(path, std::strerror(errno));
    return;
  }
  write_atomically(path, [&](const fs::path& temporary) {
    std::ofstream file(temporary, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) fail_to_write(path, std::strerror(errno));
  });
}

FileLock::FileLock(const fs::path& path)
    : descriptor_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
  if (descriptor_ < 0 || flock(descriptor_, LOCK_EX) != 0)
    fail("cannot lock {}: {}", path.string(), std::strerror(errno));
}

FileLock::~FileLock() {
  close(descriptor_);
}

}  // namespace ld
