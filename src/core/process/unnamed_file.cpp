#include "core/process/unnamed_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "core/error.h"
#include "core/file_io.h"
#include "core/unique_name.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

int open_unnamed(const fs::path& folder) {
  make_folder(folder);
#ifdef O_TMPFILE
  const int unnamed = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (unnamed >= 0) return unnamed;
#endif
  // Not every file system can do that: a name that is there for a moment.
  const fs::path path = folder / ("." + unique_name() + ".partial");
  const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0) fail("cannot make a temporary file in {}: {}", folder.string(), std::strerror(errno));
  unlink(path.c_str());
  return descriptor;
}

}  // namespace

UnnamedFile::UnnamedFile(const fs::path& folder)
    : folder_(folder.empty() ? fs::path(".") : folder), descriptor_(open_unnamed(folder_)) {}

UnnamedFile::~UnnamedFile() {
  close(descriptor_);
}

void UnnamedFile::write(int64_t place, const void* data, size_t bytes) {
  const auto* from = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t written = pwrite(descriptor_, from, bytes, place);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      fail("cannot write {} bytes to a temporary file in {}: {}; free room on that disk", bytes,
           folder_.string(), std::strerror(errno));
    from += written;
    place += written;
    bytes -= static_cast<size_t>(written);
  }
}

void UnnamedFile::read(int64_t place, void* data, size_t bytes) const {
  auto* to = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t found = pread(descriptor_, to, bytes, place);
    if (found < 0 && errno == EINTR) continue;
    if (found <= 0)
      fail("cannot read {} bytes of a temporary file in {}: {}", bytes, folder_.string(),
           found == 0 ? "it ends before" : std::strerror(errno));
    to += found;
    place += found;
    bytes -= static_cast<size_t>(found);
  }
}

}  // namespace ld
