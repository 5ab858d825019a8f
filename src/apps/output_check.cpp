#include "apps/output_check.h"

#include <fcntl.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>

#include "core/error.h"
#include "core/file_identity.h"
#include "core/unique_name.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

/// Whether what is written goes somewhere else than into a file.
bool is_stream(const fs::path& path) {
  return path.empty() || is_special(path) || path == "/dev/stdout" || path == "/dev/stderr";
}

/// The nearest of the file's folders that is there: those below it are made when the file is written.
fs::path nearest_folder(const fs::path& file) {
  std::error_code error;
  fs::path folder = fs::absolute(file, error).parent_path();
  while (folder.has_relative_path() && !fs::exists(fs::symlink_status(folder, error)))
    folder = folder.parent_path();
  return folder;
}

/// Asks the system by doing it: permissions, read-only disks and full ones differ in how they say so.
void try_to_write(const fs::path& folder, const fs::path& file) {
  const fs::path trial = folder / fmt::format(".{}.trial", unique_name());
  const int descriptor = open(trial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0)
    fail_usage("cannot write {}: no file can be made in {}: {}; choose another folder", file.string(),
               folder.string(), std::strerror(errno));
  close(descriptor);
  unlink(trial.c_str());
}

}  // namespace

void require_extension(const std::string& option, const fs::path& path,
                       const std::vector<std::string>& extensions) {
  if (is_stream(path)) return;
  const std::string extension = lower_extension(path);
  if (std::count(extensions.begin(), extensions.end(), extension) > 0) return;
  fail_usage(
      "{} {}: {}; expected {}", option, path.string(),
      extension.empty() ? "no extension" : fmt::format("the extension '{}'", path.extension().string()),
      fmt::join(extensions, " or "));
}

void require_writable(const std::vector<fs::path>& files) {
  std::set<fs::path> tried;
  for (const fs::path& file : files) {
    if (is_stream(file)) continue;
    std::error_code error;
    if (fs::is_directory(file, error))
      fail_usage("cannot write {}: it is a folder; expected the name of a file", file.string());
    // A link is followed, and the file behind it replaced.
    const bool link = fs::is_symlink(file, error) && fs::exists(file, error);
    const fs::path folder = nearest_folder(link ? fs::canonical(file, error) : file);
    if (tried.insert(folder).second) try_to_write(folder, file);
  }
}

}  // namespace ld
