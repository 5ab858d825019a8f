// Whether two paths lead to one file, whatever they are called: no output may replace an input.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

namespace ld {

/// Of a file that is there, its device and inode, so that links and relative paths do not matter. Of one that
/// is not, the path that it would have with the links of its folders followed.
class FileIdentity {
 public:
  explicit FileIdentity(const std::filesystem::path& path);
  bool operator<(const FileIdentity& other) const { return key() < other.key(); }
  bool operator==(const FileIdentity& other) const { return key() == other.key(); }

 private:
  std::tuple<const dev_t&, const ino_t&, const std::filesystem::path&> key() const {
    return {device_, inode_, path_};
  }

  dev_t device_ = 0;
  ino_t inode_ = 0;
  std::filesystem::path path_;  // empty when the file is there
};

/// Throws UsageError when one of the outputs is one of the inputs or another output. Empty paths count for
/// nothing. For calling before any work.
void refuse_overwriting(const std::vector<std::filesystem::path>& outputs,
                        const std::vector<std::filesystem::path>& inputs);

/// Whether a device, pipe or socket is there: it is neither read as a file nor replaced by one.
bool is_special(const std::filesystem::path& path);

/// ".exr" of "A.EXR": what kind of file a name says it is.
std::string lower_extension(const std::filesystem::path& path);

}  // namespace ld
