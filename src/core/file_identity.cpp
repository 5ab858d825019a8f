#include "core/file_identity.h"

#include <sys/stat.h>

#include <map>

#include "core/error.h"

namespace ld {
namespace fs = std::filesystem;

FileIdentity::FileIdentity(const fs::path& path) {
  struct stat found {};
  if (stat(path.c_str(), &found) == 0) {
    device_ = found.st_dev;
    inode_ = found.st_ino;
    return;
  }
  std::error_code error;
  path_ = fs::weakly_canonical(path, error);
  if (error) path_ = fs::absolute(path, error).lexically_normal();  // a loop of links, for instance
}

bool is_special(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

void refuse_overwriting(const std::vector<fs::path>& outputs, const std::vector<fs::path>& inputs) {
  std::map<FileIdentity, fs::path> read;
  for (const fs::path& input : inputs)
    if (!input.empty()) read.emplace(FileIdentity(input), input);
  std::map<FileIdentity, fs::path> written;
  for (const fs::path& output : outputs) {
    if (output.empty() || is_special(output)) continue;
    const auto [other, is_new] = written.emplace(FileIdentity(output), output);
    if (!is_new)
      fail_usage("the outputs {} and {} are one file; expected two", other->second.string(), output.string());
    const auto found = read.find(FileIdentity(output));
    if (found == read.end()) continue;
    if (found->second == output)
      fail_usage("the output {} is one of the inputs; choose another name or folder", output.string());
    fail_usage("the output {} is the input {}; choose another name or folder", output.string(),
               found->second.string());
  }
}

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& letter : extension)
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');  // in any locale
  return extension;
}

}  // namespace ld
